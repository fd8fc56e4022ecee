"""Japanese of what operators report."""

MESSAGES = {
    '"{}": {}': '"{}": {}',
    "{} bodies: {}": "{} 個の物体: {}",
    "{} meshes are soft. Press them with the left mouse button.": (
        "{} 個のメッシュを柔らかくしました。左マウスボタンで押せます。"
    ),
    "{}: {}": "{}: {}",
    "A rig holds it: its shape at rest goes where that goes.": "リグに付いています。元の形はリグの動きに従います。",
    "The mesh is coarse for the fingertip: it is pressed with {} vertices.": (
        "指先に対してメッシュが粗いため、{} 頂点に細分化して押します。"
    ),
    "The body is {} m across, over 100 times the radius of the fingertip. Set Physical Size to Custom Size in "
    "Physics > Dimple.": (
        "物体の大きさは {} m で、指先の半径の 100 倍を超えています。物理演算 > Dimple で実物の大きさを「指定した大"
        "きさ」にしてください。"
    ),
    "The edges of the mesh are {} mm long, the fingertip {} mm wide: subdivide the mesh or use a larger fingertip, "
    "for a visible dent.": (
        "メッシュの辺は {} mm、指先の幅は {} mm です。へこみが見えるように、メッシュを細分化するか、もっと大きい指先を"
        "使ってください。"
    ),
    "The mesh is coarse for this fingertip: it is subdivided further when the body is started again.": (
        "この指先にはメッシュが粗すぎます。物体をもう一度開始するとさらに細分化されます。"
    ),
    "A pressure needs an inside: close the mesh.": "圧力には内側が必要です。メッシュを閉じてください。",
    "Its materials differ in fill or pressure: {}, {} kPa acts, on the most area.": (
        "マテリアルの中身か圧力がそれぞれ違います。面積が最も大きい {}、{} kPa を使います。"
    ),
    'There is no preset "{}". There are: {}.': 'プリセット "{}" はありません。あるのは {} です。',
    "The bake was cancelled; nothing has changed": "ベイクを中止しました。何も変わっていません",
    "There is no fingertip, so nothing presses: Fingertips > Add Fingertip adds one.": (
        "指先がないため、何も押しません。「指先 > 指先を追加」で追加できます。"
    ),
    "Baked objects: {}": "ベイクしたオブジェクト: {} 個",
    "There was no bake on the selected objects": "選択したオブジェクトにベイクがありません",
    "The last frame ({}) must come after the first ({}).": (
        "最終フレーム ({}) は開始フレーム ({}) よりあとにしてください。"
    ),
    '"{}" is linked from another file. Make it local first: Object > Relations.': (
        '"{}" は別のファイルからリンクされています。先に「オブジェクト > 関係」でローカル化してください。'
    ),
    '"{}" has a mesh of another file. Make it local first: Object > Relations.': (
        '"{}" のメッシュは別のファイルのものです。先に「オブジェクト > 関係」でローカル化してください。'
    ),
    'The material of "{}" is linked from another file. Make it local first.': (
        '"{}" のマテリアルは別のファイルからリンクされています。先にローカル化してください。'
    ),
    '"{}": a material is gone: the constants of a new one act in its place.': (
        '"{}": マテリアルがなくなったため、代わりに新しいマテリアルの定数を使います。'
    ),
    "Wind and other force fields of the scene do not act on it.": (
        "シーンの風などのフォースフィールドは、この物体に働きません。"
    ),
    'The file that "{}" plays is gone: bake again.': (
        '"{}" が再生するファイルがありません。ベイクし直してください。'
    ),
    'The fingertip "{}" is disabled in the viewport, so it does not move.': (
        '指先 "{}" はビューポートで無効になっているため、動きません。'
    ),
    '"{}" has absolute shape keys. Switch its shape keys to Relative first.': (
        '"{}" のシェイプキーは絶対です。先に「相対」に切り替えてください。'
    ),
    '"{}" shows one shape key only. Switch Solo Active Shape Key off first.': (
        '"{}" はシェイプキーを一つだけ表示しています。先に「アクティブシェイプキーをソロ化」をオフにしてください。'
    ),
    '"{}" shows what its modifier "{}" makes of its mesh, and shape keys move the mesh before that. Bake to a Mesh '
    "Cache, or export.": (
        '"{}" にはモディファイアー "{}" の結果が見えていて、シェイプキーはその前のメッシュを動かします。'
        "メッシュキャッシュにベイクするか、書き出してください。"
    ),
    '"{}" is too coarse for shape keys. Subdivide it, bake to a Mesh Cache, or export.': (
        '"{}" はシェイプキーには粗すぎます。細分化するか、メッシュキャッシュにベイクするか、書き出してください。'
    ),
    '"{}" shares its mesh with other objects: its shape keys go on a copy of its own.': (
        '"{}" はメッシュをほかのオブジェクトと共有しているため、シェイプキーは専用のコピーに付けます。'
    ),
    '"{}", frame {}: {}': '"{}"、フレーム {}: {}',
    '"{}" is gone, so it cannot be baked.': '"{}" がなくなったため、ベイクできません。',
    '"{}" is being edited. Go back to Object Mode first.': (
        '"{}" は編集中です。先にオブジェクトモードに戻ってください。'
    ),
    '"{}" has no faces, so there is no surface to press. Add faces first.': (
        '"{}" に面がなく、押す表面がありません。先に面を追加してください。'
    ),
    '"{}" is a collection instance, not a mesh. Make its objects real first: Object > Apply > Make Instances Real.': (
        '"{}" はメッシュではなくコレクションインスタンスです。先に「オブジェクト > 適用 > インスタンスを実体化」を'
        "行ってください。"
    ),
    "Make Soft converts it to a mesh.": "「柔らかくする」でメッシュに変換できます。",
    "Select a mesh to press.": "押すメッシュを選択してください。",
    '"{}" is {} {}, not a mesh.': '"{0}" はメッシュではありません。',
    '"{}": vertex {} has a coordinate that is not a number ({} such vertices). Delete or move them.': (
        '"{}": 頂点 {} の座標が数ではありません（そのような頂点は {} 個）。削除するか動かしてください。'
    ),
    '"{}": all vertices lie in one point. Give the mesh a size.': (
        '"{}": すべての頂点が一点にあります。メッシュに大きさを与えてください。'
    ),
    '"{}": a Custom Size of {} mm is too large. Lower it in Physics > Dimple.': (
        '"{}": 指定した大きさ {} mm は大きすぎます。物理演算 > Dimple で小さくしてください。'
    ),
    "it is pinned by a vertex group, but none is chosen. Choose one in Physics > Dimple.": (
        "頂点グループで固定する設定ですが、グループが選ばれていません。物理演算 > Dimple で選んでください。"
    ),
    'no vertex of the pin group "{}" has a weight of 0.5 or more. Paint some.': (
        '固定グループ "{}" にウェイトが 0.5 以上の頂点がありません。ペイントしてください。'
    ),
    'there is no vertex group "{}" ({}). Choose another in Physics > Dimple.': (
        '頂点グループ "{}" ({}) がありません。物理演算 > Dimple で別のものを選んでください。'
    ),
    'material "{}": {}': 'マテリアル "{}": {}',
    "Choose them: {}.": "列を選んでください: {}。",
    "Depth Column": "深さの列",
    "Force Column": "力の列",
    "Contact (mm)": "接触 (mm)",
    "A question of the dialog has no answer.": "ダイアログの質問に答えがありません。",
    "Give {}: {}.": "{} を指定してください: {}。",
    'Collider "{}" is gone. Start again.': 'コライダー "{}" がなくなりました。もう一度始めてください。',
    'Collider "{}" has no faces, or a coordinate that is not a number. Repair it, or switch Dimple Collider off.': (
        'コライダー "{}" に面がないか、数でない座標があります。直すか、Dimple コライダーをオフにしてください。'
    ),
    "Hold Shift: force | Esc: disarm": "Shift を押している間: 力 | Esc: 力をオフ",
    "Give the participant a number or a code.": "参加者に番号かコードを付けてください。",
    "Read the consent, then begin": "説明を読んでから始めてください",
    "{} trials are answered": "{} 回の試行に回答しました",
    "The object of the experiment is gone. Open the experiment again.": (
        "実験のオブジェクトがなくなりました。実験を開き直してください。"
    ),
    "The export was cancelled; the files that were finished are kept": (
        "エクスポートを中止しました。できあがったファイルは残っています"
    ),
    "No folder is chosen. Choose where the files go.": (
        "フォルダーが選ばれていません。ファイルの保存先を選んでください。"
    ),
    "The folder is relative to the .blend file, which is not saved yet. Save the file first.": (
        "フォルダーは .blend からの相対パスですが、まだ保存されていません。先にファイルを保存してください。"
    ),
    "Exported {} files to {}": "{1} に {0} 個のファイルをエクスポートしました",
    '"{}" plays {}, which cannot be read: {}. Bake again, or export with Simulate Anew.': (
        '"{}" が再生する {} を読めません: {}。もう一度ベイクするか、「計算し直す」でエクスポートしてください。'
    ),
    '"{}" has {} vertices and its bake {}. Bake again, or export with Simulate Anew.': (
        '"{}" は {} 頂点ですが、ベイクは {} 頂点です。もう一度ベイクするか、「計算し直す」でエクスポートしてくださ'
        "い。"
    ),
    "and {} more": "ほか {} 個",
    "{}{} is there already. Choose another folder, or switch Overwrite on.": (
        "{}{}はすでにあります。別のフォルダーを選ぶか、「上書き」をオンにしてください。"
    ),
    "No format is chosen. Choose one or more.": "形式が選ばれていません。一つ以上選んでください。",
    "This Blender cannot write {}: it was built without that exporter, or its add-on is switched off. Choose "
    "another format.": (
        "この Blender では {} を書き出せません。エクスポーターなしでビルドされているか、アドオンがオフです。別の形"
        "式を選んでください。"
    ),
    "The last frame ({}) must not come before the first ({}).": (
        "最終フレーム ({}) は開始フレーム ({}) より前にできません。"
    ),
    "The simulation begins at frame {}, after the first ({}).": (
        "計算の開始がフレーム {} で、開始フレーム ({}) よりあとです。"
    ),
    "The export needs about {} MB, and {} has {} MB left. Choose another folder, fewer frames or fewer formats.": (
        "エクスポートには約 {} MB 必要ですが、{} の空きは {} MB です。別のフォルダーにするか、フレームか形式を減ら"
        "してください。"
    ),
    "Blender's exporter failed at {}: {}": "Blender のエクスポーターが {} で失敗しました: {}",
    "Blender's exporter could not finish {}. Is the disk full, or the folder read-only?": (
        "Blender のエクスポーターが {} を書き終えられませんでした。ディスクがいっぱいか、フォルダーが読み取り専用で"
        "はありませんか？"
    ),
    "Choose a port, or type its path.": "ポートを選ぶか、パスを入力してください。",
    '"{}" is a device to try.': '"{}" は試しに使えるデバイスです。',
    "Blender draws only {} frames a second, so the dead-man key lapses and there is no force. Simulate a proxy, or "
    "draw less.": (
        "Blender の描画が毎秒 {} フレームしかないため、デッドマンキーが切れて力が出ません。プロキシで計算するか"
        "、表示を軽くしてください。"
    ),
    "What is under a fingertip has changed. Lift it and arm the device again.": (
        "指先の下のものが変わりました。指を上げて、デバイスの力をもう一度オンにしてください。"
    ),
    "The device is not ready. Connect it and wait until the panel says so.": (
        "デバイスの準備ができていません。接続し、パネルに表示されるまで待ってください。"
    ),
    "Only a fingertip is selected. Select the mesh to press.": (
        "指先だけが選択されています。押すメッシュを選択してください。"
    ),
    "Nothing is selected. Select a mesh to press it.": "何も選択されていません。押すメッシュを選択してください。",
    '"{}" is being pressed already.': '"{}" はすでに押しているところです。',
    '"{}" is soft: "{}". It is prepared when you press it first.': (
        '"{}" は柔らかくなりました: "{}"。最初に押すときに準備されます。'
    ),
    '"{}" was repaired.': '"{}" を修復しました。',
    "Doubled vertices: {}. Loose vertices: {}. Faces that look inward: {}.": (
        "重複した頂点: {}。孤立した頂点: {}。内側を向いた面: {}。"
    ),
    '"{}" is soft: "{}", {} across. Press it with the left mouse button.': (
        '"{}" を柔らかくしました: "{}"、大きさ {}。左マウスボタンで押せます。'
    ),
    '"{}" has no faces, so there is no surface to press. Give it depth or a bevel first.': (
        '"{}" に面がなく、押す表面がありません。先に押し出しかベベルを付けてください。'
    ),
    '"{}" was {}converted to a mesh.': '"{}" を{}メッシュに変換しました。',
    "given a depth and": "厚みを付けて",
    "The measurement was stopped; nothing was written": "測定を中止しました。何も書き込んでいません",
    "Say where the file goes: give it a path.": "ファイルの保存先のパスを指定してください。",
    '"{}" is held by nothing, so the tip would push it away. Pin its base.': (
        '"{}" を支えるものがないため、先端に押されて動いてしまいます。底面を固定してください。'
    ),
    "the body is no thicker, or gives way": "それより深いところは物体の厚みがないか、物体が逃げます",
    "Pressed {} mm of {} mm deep: {}": "{1} mm のうち {0} mm まで押しました。{2}",
    "Measured {} mm deep with up to {} N: {}": "深さ {} mm、最大 {} N まで測定しました: {}",
    "{} h {} min": "{} 時間 {} 分",
    "{} min {} s": "{} 分 {} 秒",
    '"{}" has a scale of 0, so it is flat or a point. Give it a scale in the sidebar.': (
        '"{}" のスケールが 0 で、平らか点になっています。サイドバーでスケールを付けてください。'
    ),
    "The cache folder is relative to the .blend file, which is not saved yet. Save the file first.": (
        "キャッシュのフォルダーは .blend からの相対パスですが、まだ保存されていません。先に保存してください。"
    ),
    "Cannot make the cache folder {}: {}. Choose another.": (
        "キャッシュのフォルダー {} を作れません: {}。別のフォルダーを選んでください。"
    ),
    "cache folder": "キャッシュのフォルダー",
    "folder": "フォルダー",
    "The bake": "ベイク",
    "The export": "エクスポート",
    "the disk": "ディスク",
    "{} failed at {}: {}. Choose another {}.": "{}が {} で失敗しました: {}。別の{}を選んでください。",
    '"{}": {}.': '"{}": {}。',
    "Choose another number, or Automatic, in Physics > Dimple.": (
        "物理演算 > Dimple で別の数か「自動」を選んでください。"
    ),
    "{} must be a number from -1e9 to 1e9.": "{}は -1e9 から 1e9 までの数にしてください。",
    "Pressed {} mm deep with up to {} N": "深さ {} mm、最大 {} N まで押しました",
    '"{}" is {} mm across, so a press of {} mm would go through it. Press less deep.': (
        '"{}" の大きさは {} mm で、{} mm 押すと突き抜けます。もっと浅く押してください。'
    ),
    "No surface lies along the direction of the press at ({}). Choose another location.": (
        "({}) で押す向きに表面がありません。別の位置を選んでください。"
    ),
    'The press on "{}" is keyframed from frame {} to {}.': (
        '"{}" を押した動きを、フレーム {} から {} までのキーフレームにしました。'
    ),
    "That is beyond the scene's last frame {}.": "シーンの最終フレーム {} を超えています。",
    'Recorded {} frames of "{}" to {}: when its session has ended, it plays them from frame {} to {}.': (
        '"{1}" の {0} フレームを {2} に記録しました。押し終えると、フレーム {3} から {4} まで再生します。'
    ),
    'The recording of "{}" has ended early: {} ({}). What was recorded until then is kept.': (
        '"{}" の記録が途中で終わりました: {} ({})。それまでの記録は残っています。'
    ),
    "The recovery copy could not be written, so save the file yourself: {}": (
        "復旧用のコピーを書き込めませんでした。自分でファイルを保存してください: {}"
    ),
    '"{}" is not in this view layer, so it has no shape now. Put it there first.': (
        '"{}" はこのビューレイヤーにないため、いまの形がありません。先にビューレイヤーに入れてください。'
    ),
    '"{}": its modifiers give {} vertices now, and gave {}. What is pressed must keep its vertices: apply the modifier '
    "that changes them, or switch it off.": (
        '"{}": モディファイアーの出力がいま {} 頂点で、始めは {} 頂点でした。押すものの頂点は変わってはいけません。'
        "頂点を変えるモディファイアーを適用するか、オフにしてください。"
    ),
    '"{}" is gone, so its session has ended.': '"{}" がなくなったため、終了しました。',
    '"{}" was edited while it was pressed, so its session has ended. The edit is kept.': (
        '"{}" が押している間に編集されたため、終了しました。編集は残っています。'
    ),
    '"{}": {} m across as modelled, but constants are measured on what one can hold: it is pressed as an object of {} '
    "mm. Physical Size in Physics > Dimple changes that.": (
        '"{}": {} m で作られていますが、定数は手に持てる物で測ったものなので、{} mm の物体として押します。'
        "物理演算 > Dimple の「実物の大きさ」で変えられます。"
    ),
    "The mesh has too few vertices to hold the map. Subdivide it first.": (
        "マップを持つには頂点が少なすぎます。先にメッシュを細分化してください。"
    ),
    "{} of the vertices are over four times softer or stiffer than the material, beyond what a map can say: change "
    "K1 and K2.": (
        "頂点の {} がマテリアルより 4 倍を超えて柔らかいか硬く、マップで表せません。K1 と K2 を変えてください。"
    ),
    "Getting ready": "準備中",
    "Nothing was started": "何も始めませんでした",
    "{} {} | Esc: cancel": "{} {} | Esc: 中止",
    "Until then it goes on as it was.": "それまでは元のまま続きます。",
    'There is no material or preset "{}", which the experiment names.': (
        '実験が指定するマテリアルまたはプリセット "{}" がありません。'
    ),
    "{} {}, {} left | Esc: cancel": "{} {}、残り {} | Esc: 中止",
    "Baking": "ベイク中",
    "Exporting": "エクスポート中",
    "Measuring": "測定中",
    "air": "空気",
    "liquid": "液体",
    "solid": "固体",
    "none": "なし",
    "Which is right?": "どれが正しいですか？",
    "Force-Depth Measurement": "力と深さの測定",
}
