"""Japanese of what is tuned by eye: press by force, and what the status bar says."""

WORDS = {
    "Make Soft": "柔らかくする",
    "Compare Materials": "マテリアルを比べる",
    "Use This Material": "このマテリアルを使う",
    "Pressure (kPa)": "圧力 (kPa)",
    "How much higher the pressure inside is than outside before the body gives way: above 0 it swells, below 0 it "
    "shrinks. The constants are those without": (
        "物体が変形する前に、中の圧力が外よりどれだけ高いか。0 より大きいと膨らみ、小さいと縮みます。定数は圧力がない"
        "ときの値です"
    ),
    "Spread (mm)": "広がり (mm)",
    "Spread from k (mm)": "k による広がり (mm)",
    "How far a dent reaches beyond the fingertip; 0: as far as the surface k carries it": (
        "へこみが指先の外へどこまで広がるか。0 なら表面の k が運ぶところまで"
    ),
    "Press By": "押し方",
    "Whether a press, Ctrl F and pen pressure set a depth or a force": (
        "押すとき、Ctrl+F、ペンの筆圧が深さと力のどちらを決めるか"
    ),
    "Follow Size": "大きさに合わせる",
    "Follow the size of the body that is pressed; another value ends that": (
        "押す物体の大きさに合わせます。別の値にすると合わせなくなります"
    ),
    "Fitted Size (mm)": "合わせた大きさ (mm)",
    "Size of the body that fingertip and depth were fitted to last": (
        "指先と深さを最後に合わせた物体の大きさ"
    ),
    "By Force": "力で押す",
    "A press is by force": "力で押します",
    "Zoom": "拡大",
    "Pixels in a millimetre of the fingertip's radius": "指先の半径 1 ミリあたりのピクセル数",
    "Pixels in a millimetre of depth, or in a newton": "深さ 1 ミリ、または力 1 ニュートンあたりのピクセル数",
    "Depth": "深さ",
    "The fingertip goes to a set depth; the force is what the body answers": (
        "指先は指定した深さまで入ります。力は物体の応答です"
    ),
    "Force": "力",
    "The fingertip pushes straight into the surface with a force; the softer the body, the deeper it sinks in": (
        "指先は一定の力で面にまっすぐ押します。物体が柔らかいほど深く沈みます"
    ),
    "How deep a press goes, by depth": "深さで押すとき、どこまで押し込むか",
    "How strong a press is, by force": "力で押すとき、どれだけの力で押すか",
    "Force (g)": "力 (g)",
    "The same force, as the weight of so many grams": "同じ力を、何グラムの重さかで表します",
    "Force (N)": "力 (N)",
    "Force to press with; 0 presses to the depth": "押す力。0 は深さまで押し込みます",
    "Left drag: press with {} | F: radius {} | Ctrl F: force": "左ドラッグ: {} で押す | F: 半径 {} | Ctrl+F: 力",
    "Left drag: press {} deep | F: radius {} | Ctrl F: depth": "左ドラッグ: {} 押し込む | F: 半径 {} | Ctrl+F: 深さ",
    "1 2 3: finger": "1 2 3: 指",
    "Space: pause": "Space: 一時停止",
    "Space: go on": "Space: 続ける",
    "The fingertips stay where they are | Esc: leave the poke": "指先はそのまま止まります | Esc: 押すのを終える",
    "Enter: keep | Esc: leave": "Enter: 形を残す | Esc: 終了",
    "Paused: Play goes on, Esc ends and puts the rest shape back": (
        "一時停止中です。再生で続け、Esc で終えて元の形に戻します"
    ),
    "Paused: Space or Play goes on, Esc ends and puts the rest shape back": (
        "一時停止中です。Space または再生で続け、Esc で終えて元の形に戻します"
    ),
    "The object is linked from another file: make it local first": (
        "オブジェクトは別のファイルからリンクされています。先にローカル化してください"
    ),
    "Recording": "記録中",
    "Paused": "一時停止中",
    "A fingertip presses as a ball of this radius, whatever its shape.": (
        "指先は、どのような形でも、この半径の球として押します。"
    ),
    "Make the selected meshes soft bodies, ready to be pressed: material, real size, pins, and what is simulated": (
        "選択したメッシュを、すぐに押せる柔らかい物体にします。マテリアル、実物の大きさ、固定、計算の対象を決めます"
    ),
    "Object whose constants the material gets; unchosen, only a mesh without one gets it": (
        "マテリアルにその定数を与える、既知の物体。選ばなければ、マテリアルのないメッシュだけに与えます"
    ),
    "Repair": "修復",
    "Material": "マテリアル",
    "Weld doubled vertices, delete loose ones and turn faces outward, in the mesh itself": (
        "重複した頂点を結合し、孤立した頂点を削除し、面を外側に向けます。メッシュ自体が変わります"
    ),
    "Colors": "色",
    "Color the surface of what is pressed, with a scale": "押している物体の面を、目盛り付きの色で塗る",
    "Contact Pressure": "接触圧",
    "How hard the surface is pressed (kPa)": "面がどれだけ強く押されているか (kPa)",
    "How far the surface is below its shape at rest (mm)": "面が元の形よりどれだけ沈んでいるか (mm)",
    "Stretch": "伸び",
    "How much longer or shorter its edges are than at rest (%)": "辺が元よりどれだけ伸び縮みしたか (%)",
    "Slope K1": "傾き K1",
    "How hard the first millimetres are, with the softness that is painted (N/mm)": (
        "はじめの数ミリの硬さ。塗った柔らかさを含みます (N/mm)"
    ),
    "Knee x0": "折れ点 x0",
    "How deep the soft part reaches, with what is painted (mm)": (
        "柔らかい部分の深さ。塗った値を含みます (mm)"
    ),
    "How far a dent reaches beyond the fingertip, with what is painted (mm)": (
        "へこみが指先の外へどこまで広がるか。塗った値を含みます (mm)"
    ),
    "Thickness": "厚さ",
    "How thick the surface is, with what is painted; 100 is as measured (%)": (
        "面の厚さ。塗った値を含みます。100 は測定どおり (%)"
    ),
    "Constants": "定数",
    "The mesh keeps its own look": "メッシュの見た目のまま",
    "Shape at Rest": "元の形",
    "Draw the edges of the shape at rest where the body has left it": "物体が離れたところに、元の形の辺を描く",
    "Profile": "断面",
    "Draw a cut through the dent of the deepest fingertip": "最も深い指先のへこみの断面を描く",
    "Softness Group": "柔らかさのグループ",
    "Knee Group": "折れ点のグループ",
    "Spread Group": "広がりのグループ",
    "Thickness Group": "厚さのグループ",
    "Vertex group or float attribute that paints softness: 0.5 is as measured, 1 four times softer, 0 four times "
    "stiffer": (
        "柔らかさを塗る頂点グループまたは浮動小数点属性。0.5 は測定どおり、1 は 4 倍柔らかく、0 は 4 倍硬くなります"
    ),
    "Vertex group or float attribute that paints how deep the soft part reaches: 0.5 is x0, 1 twice and 0.25 half of "
    "it": "柔らかい部分の深さを塗る頂点グループまたは浮動小数点属性。0.5 は x0、1 はその 2 倍、0.25 は半分です",
    "Vertex group or float attribute that paints how far a dent reaches: 0.5 is the spread, 1 twice and 0.25 half of "
    "it": "へこみの広がりを塗る頂点グループまたは浮動小数点属性。0.5 は元の広がり、1 はその 2 倍、0.25 は半分です",
    "Vertex group or float attribute that paints how thick the surface is: 0.5 is the mass, 1 twice and 0.25 half of "
    "it": "面の厚さを塗る頂点グループまたは浮動小数点属性。0.5 は元の質量、1 はその 2 倍、0.25 は半分です",
    "Put a twin with a copy of the material beside the object; one press presses both, so that two can be compared": (
        "マテリアルも複製した、比較用の複製を隣に置きます。一度の押しで両方を押すので、二つを比べられます"
    ),
    "Keep the material of the selected one of two twins, and remove the copy": (
        "選択した方のマテリアルを残し、比較用の複製を取り除きます"
    ),
    "Make the object soft first": "先にオブジェクトを柔らかくしてください",
    "The object has a twin already: use one of the two materials first": (
        "オブジェクトにはすでに比較用の複製があります。先にどちらかのマテリアルを使ってください"
    ),
    "Something is being pressed: end that first, with Esc or Reset": (
        "押している最中です。先に Esc か「元の形に戻す」で終えてください"
    ),
    "The object has no twin: Compare Materials makes one": "比較用の複製がありません。「マテリアルを比べる」で作れます",
    "{} is its twin: select it and change its material": "{} が比較用の複製です。選択してマテリアルを変えてください",
    "Twin Of": "比較用の複製の元",
    "The object that this is a twin of, with another material": "別のマテリアルを持つ比較用の複製の、元のオブジェクト",
}
