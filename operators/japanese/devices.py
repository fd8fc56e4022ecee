"""Japanese of what is said about haptic devices and experiments."""

MESSAGES = {
    "{}; K = 2 pi R p, from {} to {} N/mm, pressed by a plate": "{}。板で押すと K = 2πRp、{}〜{} N/mm",
    "The answers {} cannot be kept: {}.": "回答 {} を保存できません: {}。",
    "The answer cannot be written to {}: {}.": "回答を {} に書き込めません: {}。",
    "{} is not a file of answers. Choose another.": (
        "{} は回答のファイルではありません。別のファイルを選んでください。"
    ),
    "Row {} of {} is damaged ({}). Repair it or choose another file.": (
        "{1} の {0} 行目が壊れています（{2}）。修復するか別のファイルを選んでください。"
    ),
    "Row {} of {} belongs to trial {}: a row is missing or repeated. Repair the file or choose another one.": (
        "{1} の {0} 行目は試行 {2} のものです。行が足りないか重複しています。"
        "修復するか別のファイルを選んでください。"
    ),
    "The experiment {} cannot be read: {}.": "実験 {} を読めません: {}。",
    "{} is not an experiment: {}.": "{} は実験ではありません: {}。",
    "The experiment has no tasks.": "実験に課題がありません。",
    "The experiment has more than {} trials.": "実験の試行が {} 回を超えています。",
    "it has no {}": "{} がありません",
    "Task {} of the experiment: {}.": "実験の課題 {}: {}。",
    "kind must be rating or comparison": "kind は rating か comparison にしてください",
    "condition must be {}": "condition は {} にしてください",
    "object must name a material": "object にはマテリアルの名前が必要です",
    "repeats must be 1 or more": "repeats は 1 以上にしてください",
    "steps must be 2 to 9 different words": "steps は 2 から 9 個の異なる語にしてください",
    "method must be constant or staircase": "method は constant か staircase にしてください",
    "levels must be two or more": "levels は 2 つ以上にしてください",
    "a level must be from {} to {}": "level は {} から {} までにしてください",
    "step must be above 0 and below 1": "step は 0 より大きく 1 より小さくしてください",
    "{} must be a number": "{} は数にしてください",
    "{} must be a whole number": "{} は整数にしてください",
    "A point of equality needs {} answers at two levels or more.": (
        "等価点を求めるには、2 つ以上の水準で {} 個の回答が必要です。"
    ),
    "All answers are alike: the levels do not reach the point of equality.": (
        "回答がすべて同じです。水準が等価点に届いていません。"
    ),
    "{}, {}: {}": "{}、{}: {}",
    "{}, {}: rated {} on the average of {} ({})": "{}、{}: 評点の平均 {}、{} 回 ({})",
    "{}, {}: equal at {} times its stiffness ({} to {}), just noticeable {} % ({} to {}), of {} answers": (
        "{}、{}: 硬さの {} 倍で等価 ({}〜{})、弁別閾 {} % ({}〜{})、回答 {} 個"
    ),
    "{} has answers of participant {}, or of another version of the experiment. Choose another file.": (
        "{} には参加者 {} の回答、または別の版の実験の回答が入っています。別のファイルを選んでください。"
    ),
    "{} has more answers than the experiment has trials.": "{} の回答が実験の試行より多くなっています。",
    "All trials are answered.": "すべての試行に回答しました。",
    "There is no answer {}.": "回答 {} はありません。",
    "The device cannot be opened: {}.": "デバイスを開けません: {}。",
    "The servo process ended ({}). Connect and arm again.": (
        "サーボのプロセスが終了しました（{}）。接続し直して力をオンにしてください。"
    ),
    "The servo process does not answer, so the device has no force. Disconnect, then connect again.": (
        "サーボのプロセスが応答しないため、力が出ません。切断してから接続し直してください。"
    ),
    "The mailbox of the device's servo cannot be used: {} ({}).": (
        "デバイスのサーボとの受け渡しができません: {}（{}）。"
    ),
    "A message of {} bytes is too long.": "{} バイトのメッセージは長すぎます。",
    "pyserial is not installed, so no serial device can be used. Install the extension's zip.": (
        "pyserial がないため、シリアルのデバイスを使えません。エクステンションの zip をインストールしてください。"
    ),
    "The process for the device cannot be started: {}.": "デバイス用のプロセスを開始できません: {}。",
    "Blender's Python was not found, so no device can be run. Install Blender from blender.org.": (
        "Blender の Python が見つからないため、デバイスを動かせません。blender.org の Blender をインストールしてく"
        "ださい。"
    ),
    "The connection to {} is lost ({}). Plug it in, connect, then arm again.": (
        "{} との接続が切れました（{}）。差し込んで接続し、もう一度力をオンにしてください。"
    ),
    "{} is in use by another program, or another Blender. Close that one, then connect again.": (
        "{} はほかのプログラムか別の Blender が使っています。それを閉じてから接続し直してください。"
    ),
    "There is no port {}. Is the device plugged in? Choose the port again.": (
        "ポート {} がありません。デバイスは差し込まれていますか？ポートを選び直してください。"
    ),
    "This account may not open {}. On Linux, join the group dialout (or uucp), then log in again.": (
        "このアカウントでは {} を開けません。Linux では dialout（または uucp）グループに入り、ログインし直してくだ"
        "さい。"
    ),
    "{} cannot run at {} baud ({}).": "{} は {} ボーで動きません（{}）。",
    "{} is not a serial port that can be opened ({}).": "{} は開けるシリアルポートではありません（{}）。",
    "The device disarmed itself.": "デバイスが自分で力をオフにしました。",
    "The device received no commands in time and stopped its motors. Arm it again.": (
        "デバイスに指令が届かず、モーターが止まりました。もう一度力をオンにしてください。"
    ),
    "An angle sensor of the device gives impossible readings. Check its cables, then arm the device again.": (
        "デバイスの角度センサーがありえない値を出しています。ケーブルを確かめ、もう一度力をオンにしてください。"
    ),
    "A fingertip of the device was faster than any hand. Arm the device again.": (
        "デバイスの指先が人の手より速く動きました。もう一度力をオンにしてください。"
    ),
    "The device did not arm: lift all fingertips, check that its motors are on, and arm it again.": (
        "デバイスの力がオンになりませんでした。指先をすべて上げ、モーターを確かめてから、もう一度オンにしてください。"
    ),
    "The device lost too many frames. Check the cable or the network, then arm it again.": (
        "通信で失われたフレームが多すぎます。ケーブルかネットワークを確かめ、もう一度力をオンにしてください。"
    ),
    "Nothing answers within 1 s. Check port, baud rate ({}) and power of the {}.": (
        "1 s 以内に応答がありません。ポート、ボーレート ({})、{} の電源を確かめてください。"
    ),
    "The device answers but streams no positions. Switch it off and on, then connect again.": (
        "デバイスは応答しますが位置を送ってきません。電源を入れ直してから接続してください。"
    ),
    "The device is silent: the connection is lost. When it is back, arm it again.": (
        "デバイスから何も届かず、接続が切れています。戻ったらもう一度力をオンにしてください。"
    ),
    "The device was silent for more than 100 ms. Arm it again.": (
        "デバイスから 100 ms を超えて何も届きませんでした。もう一度力をオンにしてください。"
    ),
    "Device or computer stood still for more than 100 ms, or the device's clock is wrong. Arm it again.": (
        "デバイスかコンピューターが 100 ms を超えて止まったか、デバイスの時計がずれています。もう一度力をオンにして"
        "ください。"
    ),
    "A fingertip was faster than 1.5 m/s. Arm the device again.": (
        "指先が 1.5 m/s より速く動きました。もう一度力をオンにしてください。"
    ),
    "The simulation gave forces that are not numbers. Reset it and arm the device again.": (
        "計算した力が数になりませんでした。リセットして、もう一度力をオンにしてください。"
    ),
    "{} of the frames are lost on the line. Check the cable or the network, then arm the device again.": (
        "フレームの {} が通信で失われています。ケーブルかネットワークを確かめ、もう一度力をオンにしてください。"
    ),
    "{} baud cannot carry the {} positions a second of the {}, {} at most. Raise the baud rate, on the device too, "
    "or use a device that is made for a lower rate (tick_hz).": (
        "{0} ボーでは {2} の毎秒 {1} 回の位置を送れません（最大 {3} 回）。デバイス側も含めてボーレートを上げるか、"
        "もっと低い速さ (tick_hz) のデバイスを使ってください。"
    ),
    "The device file {} cannot be read: {}.": "デバイスのファイル {} を読めません: {}。",
    "The device file {} has no {}; see {}.": "デバイスのファイル {} に {} がありません。{} を見てください。",
    "The device file {} is not valid: {}.": "デバイスのファイル {} が正しくありません: {}。",
    "[{}] must be a table": "[{}] は表にしてください",
    "{} must be text, not {}": "{} は {} ではなく文字列にしてください",
    "{} must be a number, not {}": "{} は {} ではなく数にしてください",
    "{} must be a whole number, not {}": "{} は {} ではなく整数にしてください",
    "{} must be a list of three, not {}": "{} は {} ではなく 3 つのリストにしてください",
    "continuous_force_n and peak_force_n must be above 0, {} at most, and not fall in this order": (
        "continuous_force_n と peak_force_n は 0 より大きく最大 {} とし、この順に減らないようにしてください"
    ),
    "hold_s, zero_s and latch_s must rise, to {}, {} and {} at most": (
        "hold_s、zero_s、latch_s はこの順に大きく、最大 {}、{}、{} にしてください"
    ),
    "tip_speed_m_s must be above 0, {} at most": "tip_speed_m_s は 0 より大きく、最大 {} にしてください",
    "l1_m and l2_m must be above 0, 2 at most": "l1_m と l2_m は 0 より大きく、最大 2 にしてください",
    "viscous_ns_m must be from 0 to 20": "viscous_ns_m は 0 から 20 までにしてください",
    "the workspace must be within reach": "作業域は届く範囲にしてください",
    "adc_bits and dac_bits must be from 8 to 16": "adc_bits と dac_bits は 8 から 16 までにしてください",
    "span_deg must be above 0, 360 at most": "span_deg は 0 より大きく、最大 360 にしてください",
    "angles_deg and centres_deg must be from -360 to 360": (
        "angles_deg と centres_deg は -360 から 360 までにしてください"
    ),
    "torque_limits_nm must be above 0, 60 at most": "torque_limits_nm は 0 より大きく、最大 60 にしてください",
    "id must be from 0 to 255": "id は 0 から 255 までにしてください",
    "tick_hz must be from 250 to 2000, and its period shorter than hold_s": (
        "tick_hz は 250 から 2000 までとし、その周期は hold_s より短くしてください"
    ),
    "The device speaks protocol {}.{}, this Dimple {}.{}: they do not understand each other. Update the older of "
    "the two.": "デバイスのプロトコルは {}.{}、この Dimple は {}.{} で、通信できません。古いほうを更新してください。",
    "The device is not the one of the device file ({}): it reports {}. Choose the file of this device.": (
        "デバイスのファイル ({}) のデバイスではありません（報告: {}）。このデバイスのファイルを選んでください。"
    ),
    "The connection to {} is lost ({}). Connect, then arm again.": (
        "{} との接続が切れました（{}）。接続し、もう一度力をオンにしてください。"
    ),
    "{} is not an address of a device. Write it as {}.": (
        "{} はデバイスのアドレスではありません。{} のように書いてください。"
    ),
    "{} cannot be reached ({}).": "{} に届きません（{}）。",
    "{} {} instead of {}": "{0} が {2} でなく {1}",
}
