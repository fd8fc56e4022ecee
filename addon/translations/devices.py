"""Japanese of the haptic device."""

WORDS = {
    "Connect": "接続",
    "Arm": "力をオン",
    "Disarm": "力をオフ",
    "Calibrate Origin": "原点を合わせる",
    "Connect or disconnect the haptic device. It exerts no force until it is armed": (
        "力覚デバイスを接続、または切断します。力をオンにするまで力は出ません"
    ),
    "Allow force while Shift or the device's own button is held. Esc disarms": (
        "Shift またはデバイスのボタンを押している間だけ力を出します。Esc で力をオフにします"
    ),
    "For scripts: how long the dead-man key counts as held": "スクリプト用: デッドマンキーを押しているとみなす時間",
    "End all force of the device at once": "デバイスの力をすぐにすべて切ります",
    "Place the middle of the fingertips, as you hold them now, at the 3D cursor": (
        "今の指先の中央を 3D カーソルの位置に合わせます"
    ),
    "Port": "ポート",
    "Serial port of the device, its path, or udp:HOST:PORT": (
        "力覚デバイスのシリアルポート、そのパス、または udp:HOST:PORT"
    ),
    "Device File": "デバイスファイル",
    "TOML file with the numbers of the device. Empty: the Haptic Master's": (
        "デバイスの数値を書いた TOML ファイル。空欄なら Haptic Master のもの"
    ),
    "Workspace Scale": "作業空間の倍率",
    "Scale": "倍率",
    "How many times the movement of the hand is enlarged on the body": "手の動きに対する物体上の動きの倍率",
    "Origin": "原点",
    "Where in the scene the calibrated position of the device is": "デバイスの基準位置に対応するシーン内の位置",
    "Center (mm)": "中心 (mm)",
    "The position of the device that corresponds to the origin": "原点に対応するデバイス上の位置",
    "Haptic Device": "力覚デバイス",
    "Disconnect": "切断",
    "Ready, no force": "準備完了、力なし",
    "Hold Shift": "Shift を押す",
    "The force comes on once Shift is held and the fingertips touch nothing.": (
        "Shift を押している間、指先が何にも触れていなければ力がオンになります。"
    ),
    "Arming": "力をオンにしています",
    "Armed": "力がオンです",
    "Connecting": "接続中",
    "Lost": "切れました",
    "Refused": "拒否されました",
    "Round Trip": "往復時間",
    "Lost Frames": "失われたフレーム",
    "full": "上限",
    "{} Material / Rendered": "{} 材質 / 提示",
    "Renders up to": "表現できる上限",
    "K1 and K2 are stiffer than the device can render without shaking, so both are rendered softer.": (
        "K1 と K2 は、デバイスが振動せずに提示できる硬さを超えるため、どちらも柔らかく提示されます。"
    ),
    "K2 is stiffer than the device can render without shaking, so it is rendered softer.": (
        "K2 は、デバイスが振動せずに提示できる硬さを超えるため、柔らかく提示されます。"
    ),
    "K1 is stiffer than the device can render without shaking, so it is rendered softer.": (
        "K1 は、デバイスが振動せずに提示できる硬さを超えるため、柔らかく提示されます。"
    ),
    "Blender draws too slowly: the dead-man key lapses and there is no force. Simulate a proxy.": (
        "Blender の描画が遅すぎます。デッドマンキーが切れて力が出ません。プロキシを使ってください。"
    ),
    "At its knee the material needs more force than the device can exert.": (
        "折れ点で、この材質にはデバイスが出せる以上の力が必要です。"
    ),
    "Press Play to feel the selected object.": "再生を押すと、選択したものに触れられます。",
}
