"""Japanese of calibration and the virtual measurement."""

BUTTONS = {
    "Calibrate": "キャリブレーション",
    "Calibrate from File...": "ファイルからキャリブレーション...",
    "Softness from Pokes": "押し込み記録から柔らかさを塗る",
    "Softness from Pokes...": "押し込み記録から柔らかさを塗る...",
    "Apply to Material": "マテリアルに適用",
    "Discard": "破棄",
    "Keep as My Material": "自分のマテリアルとして保存",
    "Measure": "測定",
    "Measure to File...": "測定してファイルへ...",
}

FILES = {
    "Fit a material to a force-depth file of an instrument: CSV or text, unedited": (
        "測定器の力と深さのファイル (CSV またはテキスト、書き出されたまま) に合う材質の定数を求めます"
    ),
    "File": "ファイル",
    "What the instrument wrote: CSV or text": "測定器が書き出したもの。CSV またはテキスト",
    "Filter": "フィルター",
    "Files that are shown": "表示するファイル",
    "Tip": "先端",
    "What pressed the object": "物体を押したもの",
    "Tip Radius (mm)": "先端の半径 (mm)",
    "Radius of what pressed the object": "物体を押したものの半径",
    "Point": "点",
    "Something small that touches at a point, as in the paper": "論文と同じく、一点で触れる小さなもの",
    "Flat Punch": "平面圧子",
    "A flat, round face that goes in as one": "平らで丸い面がそのまま入ります",
    "Ball": "球",
    "A round tip, like a fingertip": "指先のような丸い先端",
    "Object Size (mm)": "物体の大きさ (mm)",
    "Edge of the object that was pressed, for k; 0 is not known": "k を求めるための、押した物体の辺。0 は不明です",
    "Section (mm²)": "断面積 (mm²)",
    "Section of the surface as a beam, for k by Eq. (10); 0 is not known": (
        "式 (10) の k のための、表面を梁とみた断面積。0 は不明です"
    ),
    "Young's Modulus (MPa)": "ヤング率 (MPa)",
    "Of the surface, for k by Eq. (10); 0 is not known": "式 (10) の k のための、表面のヤング率。0 は不明です",
    "Depth Column": "深さの列",
    "Header of the column of depth, or its number counted from 1": "深さの列の見出し、または 1 から数えた番号",
    "Force Column": "力の列",
    "Header of the column of force, or its number counted from 1": "力の列の見出し、または 1 から数えた番号",
    "Depth Unit": "深さの単位",
    "mm, m, um or in": "mm、m、um、in のいずれか",
    "Force Unit": "力の単位",
    "N, gf, kgf, mN, kN or lbf": "N、gf、kgf、mN、kN、lbf のいずれか",
    "Decimal": "小数点",
    "The decimal mark, . or ,": "小数点の記号。. または ,",
    "Table": "表",
    "Which of several tables, counted from 1": "複数の表のうちどれか。1 から数えます",
    "Sign of Force": "押す力の符号",
    "Sign of a pressing force": "押すときの力の符号",
    "Inward": "押し込む向きの符号",
    "Sign of a depth that grows as the tip goes in": "先端が入るにつれて増える深さの符号",
    "Detected": "自動検出",
    "As the file shows it": "ファイルから分かるとおり",
    "Positive": "正",
    "The number grows": "数値が増えます",
    "Negative": "負",
    "The number falls": "数値が減ります",
    "Order": "順序",
    "written: rows as they were measured; reversed: from the last to the first": (
        "written: 測定した順の行。reversed: 最後から最初への行"
    ),
    "From (mm)": "開始 (mm)",
    "Depth reading before which rows are left out; all are used unless set": (
        "これより手前の深さの行を除きます。設定しなければすべて使います"
    ),
    "Until (mm)": "終了 (mm)",
    "Depth reading beyond which rows are left out, as where the object was torn": (
        "これより先の深さの行を除きます。物体が破れたところなどに使います"
    ),
    "Cycle": "回",
    "Which of several presses, counted from 1": "複数回の押し込みのうちどれか。1 から数えます",
    "Contact (mm)": "接触 (mm)",
    "Depth reading at first touch; detected unless set": "最初に触れたときの深さの読み。設定しなければ自動で検出します",
    "Question": "質問",
    "What the file does not say": "ファイルだけでは決まらないこと",
    "Answer to what the file does not say": "ファイルだけでは決まらないことへの答え",
    "Drop a force-depth file (CSV, text) into the viewport.": (
        "力と深さのファイル (CSV、テキスト) をビューポートにドロップしてください。"
    ),
}

RESULT = {
    "Calibration": "キャリブレーション",
    "The measurement behind these constants": "この定数のもとになった測定",
    "The last result, until it is applied to a material": "マテリアルに適用する前の、最後の結果",
    "Notes": "説明",
    "Slopes": "傾きの数",
    "One": "一つ",
    "Two": "二つ",
    "First Touch": "最初の接触",
    "Tare": "風袋",
    "Measured Range": "測定範囲",
    "k, Eqs. 9, 10": "k、式 9, 10",
    "k, Force Balance": "k、力の釣り合い",
    "Pretension": "初期張力",
    "Hysteresis Loss": "ヒステリシス損失",
    "Residual": "残差",
    "Spread": "広がり",
    "Paint softness from a table of pokes: x, y, z, depth and force, in places on the object as it stands": (
        "押した記録の表 (x, y, z, 深さ, 力) から柔らかさを塗ります。場所は今ある物体の上の位置です"
    ),
    "Table of pokes: CSV or text": "押した記録の表。CSV またはテキスト",
    "Largest Error from Points": "測定点からの最大誤差",
    "{} of full scale": "フルスケールの {}",
    "Just-Noticeable Difference": "弁別閾 (JND)",
    "The constants were edited after the measurement.": "定数は測定の後で編集されています。",
    "Give the active material the calibrated constants and their source, and the body its measured size": (
        "アクティブマテリアルにキャリブレーションした定数とその出典を、物体に測定時の大きさを与えます"
    ),
    "Surface Spring": "表面のばね",
    "Also set k, where it follows from the size of the object": "物体の大きさから分かった場合は k も設定します",
    "Also set the damping ratio, where it follows from the unloading curve": (
        "除荷曲線から分かる場合は減衰比も設定します"
    ),
    "Discard the result of the calibration; materials do not change": (
        "キャリブレーションの結果を捨てます。マテリアルはそのままです"
    ),
}

VIRTUAL = {
    "Virtual Press": "仮想の押し込み",
    "What pressed the object when it was measured": "測定のとき物体を押したもの",
    "Radius of what pressed the object when it was measured": "測定のとき物体を押したものの半径",
    "Press At": "押す場所",
    "Where the tip presses": "先端が入る場所",
    "Top": "上面",
    "Straight down on the middle": "中央を真上から押します",
    "3D Cursor": "3Dカーソル",
    "Straight into the surface, where the 3D cursor is nearest to it": "3D カーソルに最も近い表面をまっすぐ押します",
    "Object": "対象",
    "Vertices": "頂点数",
    "Law": "法則",
    "Predicted for {} mm": "{} mm での予測",
    "As Painted": "塗った値",
    "Fingertip": "指先",
    "Press the active object with a round tip, virtually, and write force against depth as a CSV file": (
        "アクティブオブジェクトを丸い先端で仮想的に押し、深さに対する力を CSV ファイルに書き出します"
    ),
    "Radius of the tip; 0 is that of the tip that measured the material": (
        "先端の半径。0 は材質を測定した先端の半径です"
    ),
    "Where the CSV goes": "CSV の保存先",
    "Check Existing": "既存の確認",
    "Ask before a file is overwritten": "ファイルを上書きする前に確認します",
    "How deep to press; 0 is the measured depth": ("どこまで押し込むか。0 は材質を測定した深さまでです"),
    "Rows": "行数",
    "Rows of the file": "ファイルの行数",
    "Measuring: Esc cancels": "測定しています。Esc で中止します",
}

WORDS = {**BUTTONS, **FILES, **RESULT, **VIRTUAL}
