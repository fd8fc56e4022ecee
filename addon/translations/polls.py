"""Japanese of why an operator cannot be used now: the tooltip of a greyed-out button."""

WORDS = {
    "A bake or a virtual press is running; Esc cancels it": (
        "ベイクまたは仮想の押し込みを実行中です。Esc で中止できます"
    ),
    "A poke is running; Esc leaves it": "押しているところです。Esc で終了します",
    "All three fingertips are in use; take one out of its slot first": (
        "3 つの指先はすべて使われています。先にどれかをスロットから外してください"
    ),
    "Calibrate with a file first": "先にファイルでキャリブレーションしてください",
    "Go back to Object Mode first": "先にオブジェクトモードに戻ってください",
    "Go back to Object Mode to bake": "ベイクするにはオブジェクトモードに戻ってください",
    "Go back to Object Mode to calibrate": "キャリブレーションするにはオブジェクトモードに戻ってください",
    "Go back to Object Mode to play": "再生するにはオブジェクトモードに戻ってください",
    "Go back to Object Mode to press": "押すにはオブジェクトモードに戻ってください",
    "Open an experiment first": "先に実験を開いてください",
    "Agree to the text first": "先に説明に同意してください",
    "All trials are answered": "すべての試行に回答しました",
    "Present the object first; in a comparison, both": "先に対象を提示してください。比較では両方を提示します",
    "No haptic device is ready": "使える力覚デバイスがありません",
    "Poke or play first: there is nothing to record": "先に押すか再生してください。記録するものがありません",
    "Settings of a library override would not be saved: make the object local first": (
        "ライブラリオーバーライドの設定は保存されません。先にローカル化してください"
    ),
    "Select a mesh first": "先にメッシュを選択してください",
    "Select the mesh to press": "押すメッシュを選択してください",
    "Select the mesh to press, in Object Mode": "オブジェクトモードで、押すメッシュを選択してください",
    "The material is linked from another file: make it local first": (
        "マテリアルは別のファイルからリンクされています。先にローカル化してください"
    ),
    "There is no material with these constants": "この定数を持つマテリアルはありえません",
}
