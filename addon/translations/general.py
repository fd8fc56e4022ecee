"""Japanese of every subject that has no file of its own."""

BUTTONS = {
    "Get Ready": "準備",
    "Poke": "押す",
    "Play": "再生",
    "Pause": "一時停止",
    "Reset": "元の形に戻す",
    "Record": "記録",
    "Stop Recording": "記録を停止",
    "Bake": "ベイク",
    "Bake to Shape Keys": "シェイプキーにベイク",
    "Remove Bake": "ベイクを外す",
    "Dimple Animation...": "Dimple アニメーション...",
    "Export Animation": "アニメーションをエクスポート",
    "Apply Preset": "プリセットを適用",
    "Add Material Preset": "マテリアルプリセットを追加",
    "Nylon cube, air, 50 mm": "ナイロンの立方体、空気、50 mm",
    "Vinyl cube, air, 165 mm": "ビニールの立方体、空気、165 mm",
    "Vinyl cube, water, 165 mm": "ビニールの立方体、水、165 mm",
}

MATERIAL = {
    "Softness (mm)": "柔らかさ (mm)",
    "How deep a fingertip of 10 mm sinks in with 5 N; to change it scales how hard the material is": (
        "半径 10 mm の指先を 5 N で押したときに沈む深さ。変えると、マテリアルの硬さ全体が変わります"
    ),
    "What the object is made of, from soft to hard: each picture is a press with 5 N": (
        "オブジェクトの材質。柔らかいものから順に並び、どの絵も 5 N で押したところです"
    ),
    "K1 (N/mm)": "K1 (N/mm)",
    "Force per depth of a press, up to the knee": "折れ点までの、押し込み深さあたりの力",
    "K2 (N/mm)": "K2 (N/mm)",
    "Force per depth of a press, beyond the knee": "折れ点を越えた後の、押し込み深さあたりの力",
    "Knee x0 (mm)": "折れ点 x0 (mm)",
    "Depth at which the slope changes from K1 to K2": "傾きが K1 から K2 に変わる深さ",
    "Surface k (N/mm)": "表面の k (N/mm)",
    "Stiffness of the surface against stretching: the stiffer, the farther a dent reaches": (
        "表面の伸びに対する硬さ。硬いほど、へこみは遠くまで広がります"
    ),
    "Mass From": "質量の与え方",
    "How the mass of the body is given": "物体の質量をどのように与えるか",
    "Density": "密度",
    "The mass follows from the density and the volume of the body": "密度と物体の体積から質量を求めます",
    "Mass": "質量",
    "The mass of the whole body is given": "物体全体の質量を与えます",
    "Density (kg/m³)": "密度 (kg/m³)",
    "Mass per volume of the body; water has 1000": "物体の体積あたりの質量。水は 1000 です",
    "Mass (kg)": "質量 (kg)",
    "Mass of the whole body if it were all of this material": "全体がこの材質でできているとしたときの物体の質量",
    "Damping Ratio": "減衰比",
    "0 is undamped, 1 is critically damped": "0 は減衰なし、1 は臨界減衰です",
    "Friction": "摩擦係数",
    "Coefficient of friction between the surface and fingertips or ground; 0 is frictionless": (
        "表面と指先や地面との間の摩擦係数。0 は摩擦なしです"
    ),
    "Fill": "中身",
    "What the surface encloses": "表面の内側にあるもの",
    "Air": "空気",
    "The enclosed air is compressed: the pressure rises and the volume falls a little": (
        "中の空気が縮みます。圧力で押し返し、少し体積が減ります"
    ),
    "Liquid": "液体",
    "The enclosed liquid keeps its volume: where a dent goes in, the body bulges elsewhere": (
        "中の液体は体積を保ちます。押し込んだ分だけ別の場所が膨らみます"
    ),
    "Solid": "固体",
    "Rubber, jelly or flesh to the core: it keeps its volume, and gives way round a fingertip": (
        "ゴム、ゼリー、肉のように中まで詰まったもの。体積を保ち、指先のまわりがやわらかくへこみます"
    ),
    "None": "なし",
    "Nothing is enclosed, so there is no pressure. Suits open meshes": (
        "何も入っていないので圧力はありません。開いたメッシュに適しています"
    ),
    "Source": "出典",
    "Edited": "編集済み",
    "The constants were changed by hand after they had been measured": "定数は、測定された後に手で変更されました",
    "Where these constants were measured; empty when typed in": (
        "この定数をどこで測定したか。手で入力した場合は空です"
    ),
}

BODY = {
    "Dimple": "Dimple",
    "Settings of Dimple": "Dimple の設定",
    "Make this mesh a soft body that can be pressed": "このメッシュを、押せる柔らかい物体にします",
    "Pinned": "固定",
    "Which part of the body is pinned": "物体のどこを固定するか",
    "Base": "底",
    "The lowest tenth of the body is pinned; a flat sheet is pinned along its border": (
        "物体の下から一割を固定します。平らなシートは縁を固定します"
    ),
    "Vertex Group": "頂点グループ",
    "Vertices with a weight of 0.5 or more in the pin group are pinned": (
        "固定グループのウェイト 0.5 以上の頂点を固定します"
    ),
    "Nothing is pinned: the body can be pushed away, fall and roll": (
        "どこも固定しません。物体は押されて動き、落ち、転がります"
    ),
    "Pin Group": "固定グループ",
    "Vertex group that is pinned, where its weight is 0.5 or more": (
        "固定する頂点グループ。ウェイト 0.5 以上を固定します"
    ),
    "Physical Size": "実物の大きさ",
    "How large the real object is": "実物がどれだけ大きいか",
    "As Modeled": "モデルのまま",
    "The body is as large as it is in the scene": "シーンでの大きさをそのまま実物の大きさとします",
    "Custom Size": "指定した大きさ",
    "The body represents a real object of the given size, whatever its size in the scene": (
        "シーンでの大きさにかかわらず、指定した大きさの実物を表します"
    ),
    "Size (mm)": "大きさ (mm)",
    "Largest dimension of the real object": "実物の最も長い寸法",
    "Dimple presses meshes. Make Soft converts this object to one.": (
        "Dimple が押せるのはメッシュです。「柔らかくする」がこのオブジェクトをメッシュに変換します。"
    ),
}

SESSION = {
    "Fingertip 1": "指先 1",
    "Fingertip 2": "指先 2",
    "Fingertip 3": "指先 3",
    "Object that presses as a fingertip; it can be keyframed": ("指先として押すオブジェクト。キーフレームで動かせます"),
    "Fingertip Radius (mm)": "指先の半径 (mm)",
    "Finger": "指",
    "The fingertip the mouse moves": "マウスで動かす指先",
    "Poke Along": "押す向き",
    "Direction in which the fingertip presses": "指先を押し込む向き",
    "View": "視線",
    "The fingertip moves away from the viewer, into the screen": "指先は手前から奥へ、画面の中へ進みます",
    "Surface": "面",
    "The fingertip moves straight into the surface it touches": "指先は触れた面にまっすぐ入ります",
    "Gravity": "重力",
    "Apply the gravity of the scene to the body": "シーンの重力を物体に加えます",
    "Ground": "地面",
    "A floor at height 0 of the scene that nothing falls through": "シーンの高さ 0 にある、何も通り抜けない床",
    "Cache Folder": "キャッシュフォルダー",
    "Where recordings go. Empty: beside the .blend file, or Dimple's own folder if it is not saved": (
        "記録の保存先。空なら .blend ファイルの隣、未保存なら Dimple 自身のフォルダー"
    ),
    "Frame Step": "フレーム間隔",
    "Make one shape key for this many frames": "このフレーム数ごとにシェイプキーを一つ作ります",
    "Overlay": "オーバーレイ",
    "Draw fingertips, forces and numbers in the viewport": "指先、力、数値をビューポートに描きます",
    "Chart": "グラフ",
    "Draw force against depth, with the material's curve": "深さに対する力を、マテリアルの曲線に重ねて描きます",
    "State": "状態",
    "What the session is doing": "セッションが今していること",
    "Sidebar Tab": "サイドバーのタブ",
    "Name of the tab in the sidebar of the 3D viewport": "3D ビューポートのサイドバーに出るタブの名前",
    "Default Cache Folder": "既定のキャッシュフォルダー",
    "Where recordings go when neither the scene names a folder nor the file is saved. Empty: Dimple's own folder": (
        "シーンにフォルダーの指定がなく、ファイルも未保存のときの記録の保存先。空なら Dimple 自身のフォルダー"
    ),
}

PANELS = {
    "Sakama, Tanaka and Araki, Hosei University, Tables 1 and 2; the mass is ours, not measured there, and the tip is "
    "taken to be a fingertip of 10 mm": (
        "法政大学 坂間・田中・荒木、表 1 と表 2。質量は測定値ではなく、こちらで決めたもので、"
        "先端は 10 mm の指先とみなしています"
    ),
    "My Materials": "自分のマテリアル",
    "Measured": "測定値",
    "Press": "押す",
    "More Numbers": "その他の数値",
    "Fingertips": "指先",
    "Animate": "アニメーション",
    "Bake Options": "ベイクの設定",
    "Display": "表示",
    "Select a mesh to press it.": "押したいメッシュを選択してください。",
    "Nothing is being pressed": "何も押していません",
    "Press a soft body with a fingertip and see how it responds": "柔らかい物体を指先で押し、その応答を見ます",
    "Keep these constants as a material of your own, or remove one": (
        "これらの定数を自分のマテリアルとして保存、または削除します"
    ),
    "Force {}": "力 {}",
    "Depth {}": "深さ {}",
    "Pressure": "圧力",
    "Volume": "体積",
    "Change of Volume": "体積の変化",
    "Time": "時間",
    "Rate": "計算速度",
    "Steps per Tick": "刻みあたりのステップ",
    "Real Time": "リアルタイム比",
}

VERBS = {
    "Get the selected meshes ready to be pressed, then poke or play": (
        "選択したメッシュを押せるように準備し、続けて押すか再生します"
    ),
    "Getting ready: Esc cancels": "準備中: Esc で中止",
    "Then": "続き",
    "The operator that follows": "続けて実行するオペレーター",
    "Press the selected meshes with a fingertip: live with the mouse, or from a script at a given place": (
        "選択したメッシュを指先で押します。マウスでその場で、またはスクリプトから指定の場所を押せます"
    ),
    "Location": "位置",
    "Where to press [scene units]; by default the top of the body": "押す場所 [シーンの単位]。既定は物体の頂上です",
    "Direction": "向き",
    "Direction in which the fingertip presses; 0 is straight into the surface": (
        "指先を押し込む向き。0 は面にまっすぐ入ります"
    ),
    "Depth (mm)": "深さ (mm)",
    "How deep to press": "どこまで押し込むか",
    "Press (s)": "押す時間 (s)",
    "Time the fingertip takes to go in": "押し込むのにかける時間",
    "Hold (s)": "保つ時間 (s)",
    "Time at full depth": "一番深いところにとどまる時間",
    "Release (s)": "離す時間 (s)",
    "Time the fingertip takes to come out; 0 stays pressed": "戻すのにかける時間。0 は押したままにします",
    "Radius (mm)": "半径 (mm)",
    "Radius of the fingertip; 0 is the scene's": "指先の半径。0 はシーンの設定を使います",
    "1, 2 or 3; 0 is the scene's": "1、2、3 のいずれか。0 はシーンの設定を使います",
    "Keep": "形を残す",
    "Keep the dent at the end instead of putting the rest shape back": "終わったときに元の形へ戻さず、その形を残します",
    "Record the press and let the object play it": "押した動きを記録し、オブジェクトに再生させます",
    "Run or pause the selected bodies; fingertip objects press them. Esc ends and restores": (
        "選択した物体を動かす、または止めます。指先オブジェクトが押します。Esc で終えて元に戻します"
    ),
    "Seconds": "秒数",
    "From a script: how long to run": "スクリプトから使うとき、何秒動かすか",
    "Frames": "フレーム数",
    "From a script: go on by so many frames of the timeline as a bake does, instead of the seconds": (
        "スクリプトから使うとき、秒数の代わりに、ベイクと同じようにタイムラインを何フレーム進めるか"
    ),
    "End every session and put the rest shapes back exactly": "すべてのセッションを終え、元の形に正確に戻します",
    "Record what is being pressed, or stop; the object plays it once its session has ended": (
        "押している動きの記録を始める、または止めます。セッションが終わるとオブジェクトが再生します"
    ),
    "Simulate the selected bodies over a range of frames, pressed by the keyframed fingertip objects. "
    "As in a live press, a proxy is simulated where the mesh is too heavy. "
    "Full Mesh in Physics > Dimple bakes every vertex": (
        "キーフレームの付いた指先オブジェクトで押しながら、選択した物体を指定のフレーム範囲で計算します。"
        "リアルタイムで押すときと同じく、メッシュが重すぎる場合はプロキシを計算します。"
        "物理演算 > Dimple の「元のメッシュ」を選ぶと、すべての頂点をベイクします"
    ),
    "Target": "ベイク先",
    "What the bake becomes": "ベイクの結果を何にするか",
    "Mesh Cache": "メッシュキャッシュ",
    "A file that the object plays; to undo it, remove the modifier": (
        "オブジェクトが再生するファイル。モディファイアーを外すだけで元に戻ります"
    ),
    "Shape Keys": "シェイプキー",
    "Keyframed shape keys, which every exporter understands": (
        "キーフレームの付いたシェイプキー。どの書き出し形式でも使えます"
    ),
    "First Frame": "開始フレーム",
    "By default the scene's first frame": "既定はシーンの開始フレーム",
    "Last Frame": "最終フレーム",
    "By default the scene's last frame": "既定はシーンの最終フレーム",
    "Remove bakes and recordings from the selected objects; their files stay on the disk": (
        "選択したオブジェクトからベイクと記録を外します。ファイルはディスクに残ります"
    ),
    "Preset": "プリセット",
    "Name of a measured object, such as object_2_vinyl_air": "測定した物体の名前。例: object_2_vinyl_air",
    "Give the active material the constants of a known object, and the body its size": (
        "アクティブマテリアルに測定した物体の定数を、物体に測定時の大きさを与えます"
    ),
    "Poking: Esc leaves, Enter keeps the shape": "押しています。Esc で終了、Enter で形を残します",
    "Playing: Esc ends and puts the rest shape back": "再生中です。Esc で終えて元の形に戻します",
    "Baking: Esc cancels": "ベイク中です。Esc で中止します",
}

WORDS = {**BUTTONS, **MATERIAL, **BODY, **SESSION, **PANELS, **VERBS}
