"""Japanese of the haptic device."""

OPERATORS = {
    "Connect": "接続",
    "Arm": "力をオン",
    "Disarm": "力をオフ",
    "Calibrate Origin": "原点を合わせる",
}

WORDS = {
    "Connect the haptic device, or let go of it. It has no force until it is armed": (
        "力覚デバイスを接続、または切断します。力をオンにするまで力は出ません"
    ),
    "Let the device have force, while Shift or the device's own button is held. Esc disarms": (
        "Shift またはデバイスのボタンを押している間だけ力を出します。Esc で力をオフにします"
    ),
    "Hold (s)": "保持 (s)",
    "From a script: how long the dead-man switch is held": "スクリプトから: デッドマンスイッチを押している時間",
    "Take all force from the device at once": "デバイスの力をすぐにすべて切ります",
    "Let the middle of the fingertips, as you hold them now, be at the 3D cursor": (
        "今の指先の中央を 3D カーソルの位置に合わせます"
    ),
    "Port": "ポート",
    'Serial port of the haptic device, or any path; "emulated" is a device to try': (
        "力覚デバイスのシリアルポート、または任意のパス。「emulated」で模擬デバイスを試せます"
    ),
    "Device File": "デバイスファイル",
    "TOML file with the numbers of the device. Empty: the Haptic Master": (
        "デバイスの数値を書いた TOML ファイル。空欄なら Haptic Master"
    ),
    "Workspace Scale": "作業空間の倍率",
    "Scale": "倍率",
    "How much larger the movement on the body is than that of the hand": "手の動きに対する物体上の動きの倍率",
    "Origin": "原点",
    "Where in the scene the calibrated place of the device is": "デバイスの基準位置に対応するシーン内の位置",
    "Centre (mm)": "中心 (mm)",
    "The place on the device that is at the origin": "原点に対応するデバイス上の位置",
    "Haptic Device": "力覚デバイス",
    "Disconnect": "切断",
    "Ready, no force": "準備完了、力なし",
    "Hold Shift, untouched": "触れずに Shift を押す",
    "Arming": "力をオンにしています",
    "Armed": "力がオンです",
    "Connecting": "接続中",
    "Lost": "切れました",
    "Refused": "拒否されました",
    "State": "状態",
    "Round Trip": "往復時間",
    "Lost Frames": "失われたフレーム",
    "full": "上限",
    "{} Asked, Felt": "{} 指定、感触",
    "Renders up to": "表現できる上限",
    "K1 and K2 are not renderable: the device shakes with so stiff a wall. Both feel softer.": (
        "K1 と K2 は表現できません。この硬さではデバイスが振動するため、どちらも柔らかく感じます。"
    ),
    "K2 is not renderable: the device shakes with so stiff a wall. It feels softer.": (
        "K2 は表現できません。この硬さではデバイスが振動するため、柔らかく感じます。"
    ),
    "K1 is not renderable: the device shakes with so stiff a wall. It feels softer.": (
        "K1 は表現できません。この硬さではデバイスが振動するため、柔らかく感じます。"
    ),
    "At the knee the material needs more force than the device has.": (
        "折れ点で、この材質にはデバイスが出せる以上の力が必要です。"
    ),
    "Press Play: what is selected is then felt.": "再生を押すと、選択したものに触れられます。",
}
