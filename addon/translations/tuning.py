"""Japanese of what is tuned by eye: press by force, and what the status bar says."""

OPERATORS: dict[str, str] = {}
WORDS = {
    "Spread (mm)": "広がり (mm)",
    "How far a dent reaches beyond the fingertip": "くぼみが指先の外へどこまで広がるか",
    "Identifying: the force is an estimate so far": "同定中：力はまだ推定値です",
    "Press By": "押し方",
    "What a press, the wheel with Ctrl and a pen's pressure mean": (
        "押すとき、Ctrl とホイール、ペンの筆圧が何を表すか"
    ),
    "Depth": "深さ",
    "The fingertip goes as deep as it is told; the force is what the body answers": (
        "指先は指定した深さまで入ります。力は物体の応答です"
    ),
    "Force": "力",
    "The fingertip pushes with a force; the softer the body, the deeper it sinks in": (
        "指先は一定の力で押します。物体が柔らかいほど深く沈みます"
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
}
