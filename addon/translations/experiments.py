"""Japanese of the sensory comparison."""

WORDS = {
    "Open Experiment": "実験を開く",
    "I Agree, Begin": "同意して始める",
    "Present": "提示",
    "Answer": "回答",
    "Stop": "中止",
    "Sensory Comparison": "感覚の比較",
    "Begin an experiment on the active object, or go on with it: answers are kept beside its file": (
        "アクティブな物体で実験を始めるか続けます。回答は実験ファイルの隣に保存されます"
    ),
    "JSON or CSV file with the tasks of the experiment": "実験の課題を書いた JSON または CSV ファイル",
    "Participant": "参加者",
    "A number or code, not a name": "番号か記号。氏名は使いません",
    "The participant has read the text and agrees; stopping is possible at any time": (
        "参加者は説明を読み、同意します。いつでも中止できます"
    ),
    "Present the object of this trial: to be pressed with the device, or pressed for you where it is only seen": (
        "この試行の対象を提示します。デバイスで押すか、見るだけの条件では代わりに押して見せます"
    ),
    "Interval": "区間",
    "1 is the first, 2 the second": "1 は先、2 は後",
    "Keep this answer and go on to the next trial": "この回答を保存して次の試行に進みます",
    "Choice": "選択",
    "The step, or which of the two was stiffer": "評価の段階、または 2 つのうち硬かった方",
    "Stop here; opened again with the same participant, it goes on at this trial": (
        "ここで中止します。同じ参加者で開き直すと、この試行から続きます"
    ),
    "Trial {} of {}, Object {}": "試行 {} / {}、対象 {}",
    "Trial: answer in the panel, Esc ends it": "試行中: パネルで回答します。Esc で終了します",
    "First": "先",
    "Second": "後",
    "How like the real object is it?": "実物とどのくらい似ていますか？",
    "Which was stiffer?": "どちらが硬かったですか？",
    "All trials are answered. Thank you.": "すべての試行に回答しました。ありがとうございました。",
    "Different": "違う",
    "Slightly Alike": "少し似ている",
    "Alike": "似ている",
    "The Same": "同じ",
    (
        "You will press soft objects and say how they feel. A haptic device may push your fingers with up to 10 N; it "
        "does so only while you hold the key, and Esc stops at any time, without a reason. Answers, forces and depths "
        "are kept under a number, not under your name."
    ): (
        "柔らかい物体を押して、どう感じたかを答えていただきます。"
        "力覚デバイスが指を最大 10 N で押すことがありますが、"
        "キーを押している間だけです。Esc でいつでも理由なく中止できます。"
        "回答、力、深さは氏名ではなく番号で保存されます。"
    ),
}
