"""Japanese of what core says about meshes, materials, proxies and sessions."""

MESSAGES = {
    "{} vertices in {} frames need a picture {} pixels high, and graphics cards take {}. Export at most {} frames.": (
        "{} 頂点 × {} フレームには高さ {} ピクセルの画像が必要ですが、グラフィックボードが扱えるのは {} までです。"
        "{} フレーム以下でエクスポートしてください。"
    ),
    "Every vertex is pinned, so nothing can move. Set Pinned to None, pin fewer vertices or subdivide the mesh.": (
        "すべての頂点が固定されていて動けません。「固定」を「なし」にするか、固定する頂点を減らすか、メッシュを細分"
        "化してください。"
    ),
    "Raise its mass, lower k, K2 or the pressure, or use a coarser mesh.": (
        "質量を増やすか、k、K2、圧力を下げるか、もっと粗いメッシュを使ってください。"
    ),
    "The body is only {} across: give it a Custom Size in Physics > Dimple.": (
        "物体の大きさが {} しかありません。物理演算 > Dimple で「指定した大きさ」を設定してください。"
    ),
    "The material is so stiff or light on this mesh that a millisecond needs over {} steps.": (
        "このメッシュではマテリアルが硬すぎるか軽すぎて、1 ミリ秒に {} を超えるステップが必要です。"
    ),
    "Gravity must be three numbers and the ground's height one.": (
        "重力は 3 つの数、地面の高さは 1 つの数にしてください。"
    ),
    "A face uses a material slot that is empty. Assign a material to it.": (
        "空のマテリアルスロットを使う面があります。マテリアルを割り当ててください。"
    ),
    "{} map": "{}のマップ",
    "The body starts {} mm below the ground, so for it the ground is as low as it is. Move it up to let it fall.": (
        "物体が地面より {} mm 下から始まるので、この物体の地面はその高さとします。落とすには上に動かしてください。"
    ),
    "The {} must have one value for each of the {} vertices.": "{}には {} 頂点のそれぞれに 1 つの値が必要です。",
    "Some values of the {} are not numbers.": "{}に数でない値があります。",
    "pins": "固定",
    "softness": "柔らかさ",
    "knee": "折れ点",
    "spread": "広がり",
    "thickness": "厚さ",
    "The tip must be one of {} (it is {}).": "先端は {} のいずれかにしてください（現在 {}）。",
    "The radius of the tip must be greater than 0 mm (it is {}).": (
        "先端の半径は 0 mm より大きくしてください（現在 {}）。"
    ),
    "{} must be greater than 0 {}": "{} は 0 {} より大きくしてください",
    "The spread must not be negative": "広がりは負にできません",
    "Give either a mass or a density": "質量か密度のどちらか一方を設定してください",
    "The mass must be greater than 0 kg": "質量は 0 kg より大きくしてください",
    "The density must be greater than 0 kg/m³": "密度は 0 kg/m³ より大きくしてください",
    "The damping ratio must lie between 0 and 2": "減衰比は 0 から 2 までにしてください",
    "The friction must not be negative": "摩擦は負にできません",
    "The pressure must lie between -100 kPa and 1000 kPa": "圧力は -100 kPa から 1000 kPa までにしてください",
    "The fill must be one of {}": "中身は {} のいずれかにしてください",
    "{} is out of range (it is {}). Change it in Material > Dimple.": (
        "{}が範囲を超えています（現在 {}）。マテリアル > Dimple で変更してください。"
    ),
    "{} (it is {}). Change it in Material > Dimple.": "{}（現在 {}）。マテリアル > Dimple で変更してください。",
    "The mass": "質量",
    "The density": "密度",
    "The spread": "広がり",
    "The damping ratio": "減衰比",
    "The friction": "摩擦",
    "The pressure": "圧力",
    "both": "両方",
    "neither": "どちらもなし",
    "All vertices lie at one point, so there is nothing to press. Give the mesh a size.": (
        "すべての頂点が一点にあり、押すものがありません。メッシュに大きさを与えてください。"
    ),
    "{} vertices coincide with others and move with them.": "{} 個の頂点がほかの頂点と重なっていて、一緒に動きます。",
    "Every face has shrunk to a line or a point. Dissolve the degenerate geometry or scale it up.": (
        "すべての面が線か点につぶれています。退化した部分を溶解するか、拡大してください。"
    ),
    "The faces have no area. Dissolve the degenerate geometry first.": (
        "面に面積がありません。先に退化した部分を溶解してください。"
    ),
    "{} faces have no area and add no stiffness.": "{} 個の面に面積がなく、硬さに加わりません。",
    "{} faces were flipped to match the normals of their neighbours.": (
        "{} 個の面を、隣の面の法線に合わせて反転しました。"
    ),
    "The normals pointed inward and were recalculated for the simulation.": (
        "法線が内側を向いていたため、計算用に再計算しました。"
    ),
    "{} faces of separate parts pointed inward and were flipped for the simulation.": (
        "分かれた部分の {} 個の面が内側を向いていたため、計算用に反転しました。"
    ),
    "The mesh is a sheet and encloses no volume: its fill is off.": (
        "メッシュは一枚の面で体積を囲んでいないため、中身はなしとします。"
    ),
    "Holes closed for the pressure only: {}.": "圧力の計算でのみふさぐ穴: {} 個。",
    "{} edges are non-manifold: they join three or more faces.": (
        "{} 本の辺が非多様体です（3 つ以上の面につながっています）。"
    ),
    "{} loose vertices belong to no face and stay where they are.": (
        "{} 個の孤立した頂点はどの面にも属さず、そのまま動きません。"
    ),
    "The mesh has no faces, so there is no surface to press. Add faces first.": (
        "メッシュに面がなく、押す表面がありません。先に面を追加してください。"
    ),
    "A face refers to a vertex that does not exist. Run Mesh > Clean Up, or rebuild the mesh.": (
        "存在しない頂点を使う面があります。メッシュ > クリーンアップを実行するか、メッシュを作り直してください。"
    ),
    "There must be one material index for each triangle.": "三角形ごとに 1 つのマテリアル番号が必要です。",
    "Vertex {} has a NaN or infinite coordinate, or one beyond {} m ({} such vertices). Delete or move them.": (
        "頂点 {} の座標が NaN か無限大、または {} m を超えています（そのような頂点は {} 個）。削除するか動かしてく"
        "ださい。"
    ),
    "There is no compiled core for {} here. Install the zip of Dimple for that platform.": (
        "{} 用のコンパイル済みコアがありません。その環境用の Dimple の zip をインストールしてください。"
    ),
    "The compiled core for {} was refused ({}). Install the zip of Dimple for that platform again.": (
        "{} 用のコンパイル済みコアが使えませんでした（{}）。その環境用の Dimple の zip をもう一度インストールしてくだ"
        "さい。"
    ),
    "it has version {}, not {}": "バージョンが {} で、{} ではありません",
    "its check is off by {} mm": "確認の結果が {} mm ずれています",
    "The recording has {} vertices but the mesh now has {}. Start a new recording after changing the mesh.": (
        "記録は {} 頂点ですが、メッシュは今 {} 頂点です。メッシュを変えたあとは新しく記録してください。"
    ),
    "Sample {} has coordinates that are not numbers; it was not recorded.": (
        "サンプル {} に数でない座標があり、記録されませんでした。"
    ),
    "{} is not a PC2 point cache.": "{} は PC2 ポイントキャッシュではありません。",
    "{} is a PC2 point cache that was cut short. Bake again.": (
        "{} は途中で切れた PC2 ポイントキャッシュです。もう一度ベイクしてください。"
    ),
    "{} has a sample every {} frames, not one a frame. Bake again.": (
        "{} のサンプルは {} フレームごとで、1 フレームごとではありません。もう一度ベイクしてください。"
    ),
    "The full mesh is too stiff to simulate": "元のメッシュは硬すぎて計算できません",
    "The full mesh runs live: {}.": "元のメッシュのままリアルタイムで動きます（{}）。",
    "The full mesh would run at {} real time ({})": "元のメッシュではリアルタイムの {} の速さです（{}）",
    "{}. It is simulated anyway: {}.": "{}。それでもそのまま計算します。{}。",
    "{}, the full mesh: {}, at {} real time.": "{}。元のメッシュ（{}）、リアルタイムの {} の速さです。",
    "For self contact": "自己接触があります",
    'Its proxy would intersect "{}" at the start, so the full mesh is simulated.': (
        "プロキシが開始時に「{}」と交わるため、元のメッシュを計算します。"
    ),
    "For its rig": "リグで動きます",
    "runs at {} real time": "はリアルタイムの {} の速さで動き",
    "runs live": "はリアルタイムで動き",
    "As chosen": "選択どおりです",
    "{}. A proxy of {} vertices {}; its dents are within {} mm of the mesh's.": (
        "{}。{} 頂点のプロキシ{}、へこみの形は元のメッシュと {} mm 以内で一致します。"
    ),
    "{} vertices at {} steps per millisecond": "{} 頂点、1 ミリ秒に {} ステップ",
    "a proxy of this mesh has from {} to {} vertices, not {}": (
        "このメッシュのプロキシは {} から {} 頂点で、{} にはできません"
    ),
    "its pieces are too small for a proxy": "部分が小さすぎてプロキシを作れません",
    "its surface is too crumpled for a proxy of this size": (
        "表面の凹凸が激しく、この大きさのプロキシを作れません"
    ),
    "a proxy of this size would have holes": "この大きさのプロキシには穴が空きます",
    "a proxy of this size would lose too much of the volume": "この大きさのプロキシでは体積が失われすぎます",
    "its pins are too few for a proxy of this size": (
        "固定された頂点が少なすぎて、この大きさのプロキシを作れません"
    ),
    "A tick must be longer than 0 s (it is {}).": "刻みは 0 s より長くしてください（現在 {}）。",
    "There are at most {} fingertips.": "指先は {} 個までです。",
    "A fingertip needs a place that is a number and a radius greater than 0.": (
        "指先には、数で表した位置と 0 より大きい半径が必要です。"
    ),
    "The mesh has {} vertices: give a position for each.": "メッシュは {} 頂点です。それぞれの位置を与えてください。",
    "A pinned vertex has a position that is not a number.": "固定した頂点の位置が数ではありません。",
    "The shape at rest has a position that is not a number.": "元の形に数でない位置があります。",
    "A step of time must be 0 s or longer (it is {}).": "時間の幅は 0 s 以上にしてください（現在 {}）。",
    "The simulation blew up after {} s and was put back to rest. Lower k or K2, or raise the mass.": (
        "計算が {} s で発散したため、元の形に戻しました。k か K2 を下げるか、質量を増やしてください。"
    ),
    "The mesh has other vertices than when it was started. Reset it and start again.": (
        "開始したときとメッシュの頂点が違います。リセットしてもう一度始めてください。"
    ),
    "There is no backend {}: take native or native64.": (
        "計算方式 {} はありません。native か native64 を選んでください。"
    ),
    "The mass of a prop must be greater than 0 kg (it is {}).": (
        "小道具の質量は 0 kg より大きくしてください（現在 {}）。"
    ),
    "The prop has no faces with an area, so it cannot touch anything.": (
        "小道具に面積のある面がなく、何にも触れられません。"
    ),
    "Bodies that meet must be stepped by the same backend, with the same tick.": (
        "触れ合う物体は、同じ計算方式と同じ刻みで計算する必要があります。"
    ),
    "The mesh passes through itself at ({}) mm: {} pairs of faces, and those beside them, are left out of Self "
    "Contact.": (
        "メッシュが自分自身と交差しています。位置 ({}) mm：{} 組の面と、その隣の面は自己接触から外します。"
    ),
    'What falls must be clear of other colliders: "{}" and "{}" intersect at ({}) mm, {} pairs of faces in all. Move '
    "them apart.": (
        "落ちるものは、ほかのコライダーから離れていなければなりません。「{}」と「{}」が ({}) mm で交差しています"
        "（面の組は全部で {}）。離してください。"
    ),
    '"{}" and "{}" intersect at ({}) mm, {} pairs of faces in all. Move them apart.': (
        '"{}" と "{}" が交差しています。位置 ({}) mm、交差する面は全部で {} 組です。離してください。'
    ),
    'Collider "{}" has another number of vertices than at the start, or a coordinate that is not a number. Reset, '
    "and start again.": (
        'コライダー "{}" の頂点の数が開始時と違うか、数でない座標があります。リセットして、始め直してください。'
    ),
}
