"""Japanese of what is tuned by eye: press by force, and what the status bar says."""

OPERATORS = {"Make Soft": "柔らかくする"}
WORDS = {
    "Spread (mm)": "広がり (mm)",
    "How far a dent reaches beyond the fingertip": "くぼみが指先の外へどこまで広がるか",
    "Identifying: the force is an estimate so far": "同定中：力はまだ推定値です",
    "Press By": "押し方",
    "What a press, the wheel with Ctrl and a pen's pressure mean": (
        "押すとき、Ctrl とホイール、ペンの筆圧が何を表すか"
    ),
    "Depth": "深さ",
    "The fingertip goes to a set depth; the force is what the body answers": (
        "指先は指定した深さまで入ります。力は物体の応答です"
    ),
    "Force": "力",
    "The fingertip pushes straight into the surface with a force; the softer the body, the deeper it sinks in": (
        "指先は一定の力で面にまっすぐ押します。物体が柔らかいほど深く沈みます"
    ),
    "Press Depth (mm)": "押す深さ (mm)",
    "How deep a press goes, by depth": "深さで押すとき、どこまで押し込むか",
    "Press Force (N)": "押す力 (N)",
    "How strong a press is, by force": "力で押すとき、どれだけの力で押すか",
    "Force (N)": "力 (N)",
    "Force to press with; 0 presses to the depth": "押す力。0 は深さまで押し込みます",
    "Left drag: press with {} | Ctrl wheel: force | F: by depth": (
        "左ドラッグ: {} で押す | Ctrl+ホイール: 力 | F: 深さで押す"
    ),
    "Left drag: press {} deep | Ctrl wheel: depth | F: by force": (
        "左ドラッグ: {} 押し込む | Ctrl+ホイール: 深さ | F: 力で押す"
    ),
    "Wheel: radius | 1 2 3: finger | Space: pause | R: record | Enter: keep | Esc: leave": (
        "ホイール: 半径 | 1 2 3: 指 | Space: 一時停止 | R: 記録 | Enter: 形を残す | Esc: 終了"
    ),
    "Paused: Space or Play goes on, Esc ends and puts the rest shape back": (
        "一時停止中です。Space または再生で続け、Esc で終えて元の形に戻します"
    ),
    "{} is not selected: leave the poke, select it and poke again to press it": (
        "{} は選択されていません。押すのを終え、選択してからもう一度押してください"
    ),
    "The object is linked from another file: make it local first": (
        "オブジェクトは別のファイルからリンクされています。先にローカル化してください"
    ),
    "Recording": "記録中",
    "A fingertip presses as a ball of this radius, whatever its shape.": (
        "指先は、どのような形でも、この半径の球として押します。"
    ),
    "Make the selected meshes soft bodies, ready to be pressed: material, real size, pins, and what is simulated": (
        "選択したメッシュを、すぐに押せる柔らかい物体にします。マテリアル、実物の大きさ、固定、計算の対象を決めます"
    ),
    "Measured object whose constants a mesh without a material gets": (
        "マテリアルのないメッシュに定数を与える、測定した物体"
    ),
    "Subdivide": "細分化",
    "Cut edges that are longer than the fingertip is wide, which changes the mesh": (
        "指先の幅より長い辺を分割します。メッシュが変わります"
    ),
    "The edges are longer than the fingertip is wide.": "辺が指先の幅より長くなっています。",
    "It would show no dent. The mesh can be cut finer, in even parts.": (
        "へこみが見えません。メッシュを均等に細かく分割できます。"
    ),
}
