"""Japanese of what is said about measured files: reading and fitting."""

MESSAGES = {
    "depth": "深さ",
    "force": "力",
    "time": "時間",
    "length": "長さ",
    "section": "断面積",
    "Young's modulus": "ヤング率",
    "lines {} to {}, under “{}”": "{} 行目から {} 行目、見出し “{}”",
    "The file holds {} tables. Which one is the measurement?": "ファイルに表が {} 個あります。測定はどれですか？",
    "{} cannot be written: {}.": "{} に書き込めません: {}。",
    "The {} of the object must be a number greater than 0.": "物体の{}は 0 より大きい数にしてください。",
    "K1 {} N/mm, K2 {} N/mm, x0 {} mm": "K1 {} N/mm、K2 {} N/mm、x0 {} mm",
    "one slope {} N/mm": "傾きは一つ {} N/mm",
    "{}: {} (95 %), {} rows, residual {} % of {} N, {} of {} mm radius": (
        "{0}: {1} (95 %)、{2} 行、残差は {4} N の {3} %、{5}、半径 {6} mm"
    ),
    "sphere": "球",
    "punch": "平面圧子",
    "point": "点",
    "{}, calibrated {}": "{}、キャリブレーション {}",
    "k {} N/mm by Eqs. (9), (10)": "式 (9)、(10) による k {} N/mm",
    "k {} N/mm (95 %) by the force balance": "力のつり合いによる k {} N/mm (95 %)",
    "“{}” (column {}) in {}": "“{}”（{} 列目、単位 {}）",
    "The depth is {}, the force {}.": "深さは{}、力は{}です。",
    "The force changes by {} N before the touch.\nThe load cell drifts, and the slopes are off by {} N/mm, or the "
    "touch is earlier.": (
        "接触の前に力が {} N 変わっています。\nロードセルがずれていて傾きに {} N/mm の誤差があるか、接触がもっと早"
        "いかです。"
    ),
    "The first touch is at {} mm of the file, the tare {} N.": "最初の接触はファイルの {} mm、風袋は {} N です。",
    "The first touch is at {} mm of the file, as given, the tare {} N.": (
        "最初の接触は指定どおりファイルの {} mm、風袋は {} N です。"
    ),
    "The force is {} N where the file begins, at {} mm. At which depth was the first touch?": (
        "ファイルの始まり ({1} mm) で力が {0} N あります。最初の接触はどの深さでしたか？"
    ),
    "The noise hides the first touch. At which depth was it?": (
        "雑音のため最初の接触が分かりません。どの深さでしたか？"
    ),
    "then K1 is {} N/mm": "K1 は {} N/mm になります",
    "The force rises by no more than {} N over the first {} mm. At which depth was the first touch?": (
        "最初の {1} mm で力は {0} N しか増えません。最初の接触はどの深さでしたか？"
    ),
    "where it begins to rise: there was air before": "力が増え始めるところ（その前は空気）",
    "before: the object is that soft at first": "それより前（物体が初めはそれほど柔らかい）",
    "before the file begins: the object was pressed already": "ファイルの始まりより前（すでに押されていた）",
    "where the file begins: the load cell was not tared": "ファイルの始まり（ロードセルのゼロ合わせがされていない）",
    "There is no table in this file: no run of rows with two or more numbers. It must have a column of depth and a "
    "column of force.": (
        "このファイルに表がありません。2 つ以上の数が並ぶ行が続いていません。深さの列と力の列が必要です。"
    ),
    "In “{}”, does the mark separate thousands or decimals?": "「{}」の記号は桁区切りですか、小数点ですか？",
    "The depth falls as the force grows and was turned round.": (
        "力が増えると深さが減るため、深さの向きを逆にしました。"
    ),
    "Only {} rows lie in the range that was given; a fit needs {}.": (
        "指定された範囲に {} 行しかありません。当てはめには {} 行が必要です。"
    ),
    "{} rows outside the range that was given were left out.": "指定された範囲の外の {} 行を除きました。",
    "The rows were turned round, from the last to the first.": "行の順序を逆にしました。",
    "The depth never grows: the file holds unloading only, no press.": (
        "深さが増えていません。ファイルは除荷だけで、押し込みがありません。"
    ),
    "The file begins with its largest force, {} N, and ends with little": (
        "ファイルは最大の力 {} N で始まり、小さい力で終わります"
    ),
    "{}. In what order do its rows stand?": "{}。行はどの順に並んでいますか？",
    "from the last to the first": "最後から最初へ",
    "as they were measured": "測定した順",
    "The force goes both ways from where it begins. Which sign is a press?": (
        "力が始まりの値から両方向に変わります。どちらの符号が押す向きですか？"
    ),
    "from {} N up to {} N": "{} N から {} N へ増える",
    "from {} N down to {} N": "{} N から {} N へ減る",
    "The force is negative where it presses and was turned round.": "押す力が負のため、力の符号を逆にしました。",
    "The force is no greater at the deepest rows than at the shallowest: these are not a press, or not the right "
    "columns.": "最も深い行の力が浅い行より大きくありません。押し込みではないか、列が違います。",
    "“{}” advances evenly, like a driven depth, and “{}” does not: are the columns swapped? Which one is the depth?": (
        "“{}” は深さのように一定に進み、“{}” は進みません。入れ替わっていませんか？深さはどちらですか？"
    ),
    "{}, as the header says (a press driven by its force)": "{}、見出しのとおり（力を制御した押し込み）",
    "{}: the columns are swapped": "{}: 列が入れ替わっている",
    "No knee was found down to {} mm.\nOne slope says as much as two: K2 equals K1 and x0 is the deepest row.": (
        "{} mm まで折れ点が見つかりません。\n傾きは一つで十分です。K2 は K1 と同じ、x0 は最も深い行とします。"
    ),
    "The force falls while the depth grows.\nThe best two pieces would fall; these are the best of those that "
    "rise, as a body of the model must.": (
        "深さが増える間に力が減っています。\n最もよく合う 2 本の線は下がるため、モデルに必要な、上がる線のうち最も"
        "よいものを使いました。"
    ),
    "The object softens beyond the knee (K2 < K1).\nThat is unusual: see whether it buckles or is torn, and "
    "whether the columns of depth and force are exchanged.": (
        "折れ点より先で柔らかくなります (K2 < K1)。\nこれは珍しいことです。座屈や破れがないか、深さと力の列が入れ替"
        "わっていないか確かめてください。"
    ),
    "The file begins {} mm after the first touch.\nWhat the object answers before that was not measured: K1 and x0 "
    "hold only if it is straight down to the touch.": (
        "ファイルは最初の接触の {} mm 先から始まります。\nその手前は測定されていません。接触までまっすぐな場合にだ"
        "け K1 と x0 が成り立ちます。"
    ),
    "The law misses the measured points by up to {} % of the force.\nThat is {} N at {} mm, and {} % of full scale "
    "(RMS) over all: the curve has another shape than two straight slopes.": (
        "法則と測定点は、力の最大 {0} % ずれています。\n{2} mm で {1} N、全体ではフルスケールの {3} % (RMS) です。"
        "曲線は 2 本の直線とは違う形です。"
    ),
    "The curve is that of a solid: choose Fill: Solid.\nIts law with the same constants misses the measured points by "
    "up to {} % of the force, two slopes by {} %.": (
        "曲線は固体のものです。「中身」で「固体」を選んでください。\n測定点とのずれは、同じ定数の固体の法則で力の最大 "
        "{} %、2 本の直線では {} % です。"
    ),
    "The curve bends where the law is straight.\nNeighbouring residuals agree with each other (r = {}), so the 95 "
    "% intervals are {} times wider than independent rows would give.": (
        "法則がまっすぐなところで曲線が曲がっています。\n隣り合う残差が似ているため (r = {})、95 % 区間は独立な行の"
        "場合の {} 倍です。"
    ),
    "The curve does not determine {}.\n0 lies within the 95 % interval.": (
        "この曲線では {} が決まりません。\n95 % 区間に 0 が入ります。"
    ),
    "{} mm and {} N are unlikely for a press: check the units.": (
        "{} mm と {} N は押し込みとして不自然です。単位を確かめてください。"
    ),
    "The press is {} mm deep, more than the object's {} mm: check the units.": (
        "押し込みの深さ {} mm が物体の {} mm を超えています。単位を確かめてください。"
    ),
    "The force does not grow with the depth.\nThere is no material with these constants.": (
        "深さが増えても力が増えません。\nこの定数を持つマテリアルはありえません。"
    ),
    "Only {} rows lie beyond the first touch; a fit needs at least {}.": (
        "最初の接触より先に {} 行しかありません。当てはめには少なくとも {} 行が必要です。"
    ),
    "The tip misses the object. Move it over the place to be pressed.": (
        "先端が物体に当たりません。押す場所の上に動かしてください。"
    ),
    "a ZIP archive (an Excel or LibreOffice sheet is one too)": (
        "ZIP アーカイブ（Excel や LibreOffice のシートもこれです）"
    ),
    "an empty ZIP archive": "空の ZIP アーカイブ",
    "an old Excel or Word file": "古い Excel または Word のファイル",
    "a gzip archive": "gzip アーカイブ",
    "an xz archive": "xz アーカイブ",
    "a 7-Zip archive": "7-Zip アーカイブ",
    "a zstd archive (a .blend file may be one)": "zstd アーカイブ（.blend ファイルのこともあります）",
    "a MATLAB file": "MATLAB のファイル",
    "a MATLAB or HDF5 file": "MATLAB または HDF5 のファイル",
    "a Blender file": "Blender ファイル",
    "This is {}, not a text table. Export the measurement as CSV and open that.": (
        "これは{}で、テキストの表ではありません。測定を CSV で書き出し、それを開いてください。"
    ),
    "The file is empty. Export the measurement again.": "ファイルが空です。測定をもう一度書き出してください。",
    "The file holds binary data, not a text table. Export the measurement as CSV and open that.": (
        "ファイルはバイナリデータで、テキストの表ではありません。測定を CSV で書き出し、それを開いてください。"
    ),
    "Line {} has {} characters; a row of a table has at most {}. This is not a force-depth table, or its line ends "
    "are lost: export it again.": (
        "{} 行目が {} 文字あります。表の行は最大 {} 文字です。力と深さの表でないか、改行が失われています。もう一度"
        "書き出してください。"
    ),
    "The last line breaks off and was left out.": "最後の行が途中で切れているため除きました。",
    "{} is not a file.": "{} はファイルではありません。",
    "{} cannot be read: {}.": "{} を読めません: {}。",
    "{} is larger than {} MB, the most a measurement may have. Export one test, or fewer samples a second.": (
        "{} は測定の上限 {} MB を超えています。試験を一つだけ、またはサンプリングを粗くして書き出してください。"
    ),
    "{} pokes at {} places: each place predicted from the others, the force is off by {} (RMS; with one softness for "
    "all {}).": (
        "{1} か所で {0} 回押した記録: 各場所をほかの場所から予測すると力の誤差は {2} (RMS、全体を一つの柔らかさとす"
        "ると {3}) です。"
    ),
    "One softness is as good as a map: each place predicted from the others, the force is off by {} with a map and {} "
    "without.": (
        "一つの柔らかさで十分です。各場所をほかの場所から予測した力の誤差は、マップで {}、マップなしで {} です。"
    ),
    "No poke has a depth and a force greater than 0. Are the columns the right ones?": (
        "深さと力がともに 0 より大きい記録がありません。列は正しいですか？"
    ),
    "A map needs pokes at {} or more different places; this file has {}.": (
        "マップには {} か所以上での記録が必要です。このファイルは {} か所です。"
    ),
    "The pokes lie {} mm from the surface. Their x, y and z are places on the object as it stands in the scene, at "
    "its physical size.": (
        "押した場所が表面から {} mm 離れています。x、y、z は、シーンに置かれた物体の実物の大きさでの位置です。"
    ),
    "{} is no table of pokes: there is no column {}.": "{} は押した記録の表ではありません。列 {} がありません。",
    "The depth or the force is the same in every row, so there is no press to fit.": (
        "深さか力がすべての行で同じで、当てはめる押し込みがありません。"
    ),
    "The depth only falls, which would be a way back and no press": (
        "深さが減るだけで、押し込みではなく戻りのようです"
    ),
    "The depth turns back {} times in {} rows: they are not in the order measured, or the depth is not the column "
    "taken.": "{1} 行のうち {0} 回、深さが後戻りしています。行が測定した順でないか、深さの列が違います。",
    "{} rows in which the depth stood still were left out.": "深さが止まっている {} 行を除きました。",
    "{} rows stand apart from their neighbours and were left out ({}{}).": (
        "前後から大きく外れた {} 行を除きました ({}{})。"
    ),
    "Touches to {} mm, less deep or of a few rows only, were left out.": (
        "浅いか数行だけの接触 ({} mm) を除きました。"
    ),
    "A press has {} rows; a fit needs at least {}.": "押し込みが {} 行です。当てはめには少なくとも {} 行が必要です。",
    "The force dips by {} N before the press, as where a tip sticks; {} rows of it were left out.": (
        "押す前に力が {} N 下がっています。先端が貼り付くとこうなります。その {} 行を除きました。"
    ),
    "The touch at {} mm lies outside the depths of the file.": "接触 {} mm がファイルの深さの範囲にありません。",
    "The force falls for good from {} N at {} mm: was the specimen torn? Down to which depth should it be fitted?": (
        "{1} mm の {0} N から力が下がったままです。試料が破れましたか？どの深さまで当てはめますか？"
    ),
    "where the force begins to fall": "力が下がり始めるところ",
    "the deepest row: no tear, it answers like this": "最も深い行（破れではなく、そういう応答）",
    "There is no cycle {}: the file holds {}.": "{} 回目はありません。ファイルには {} 回あります。",
    "{} presses agree within {} % of full scale; the first is fitted.": (
        "{} 回の押し込みはフルスケールの {} % 以内で一致します。最初のものを当てはめます。"
    ),
    "The file holds {} presses that differ by up to {} % of full scale. Which one is fitted?": (
        "ファイルに {} 回の押し込みがあり、フルスケールの {} % まで違います。どれを当てはめますか？"
    ),
    "{} mm deep, up to {} N": "深さ {} mm、最大 {} N",
    "The way back returns {} % more work than the press takes": (
        "戻りの仕事が、押し込みの仕事より {} % 多くなっています"
    ),
    "{}, which no object does": "{}。このような物体はありません",
    "{}.\nNo object does that: force and depth may not be of one press.": (
        "{}。\nこのような物体はありません。力と深さが一つの押し込みのものではないかもしれません。"
    ),
    "The answer to “{}” is {} or {} (it is {}).": "“{}” の答えは {} か {} です（現在 {}）。",
    "The answer to “{}” is counted from 1 (it is {}).": "“{}” の答えは 1 から数えます（現在 {}）。",
    "The answer to “{}” is a depth in mm (it is {}).": "“{}” の答えは mm で表した深さです（現在 {}）。",
    "(the likeliest)": "（最も確からしい）",
    "The text was read as {}.": "テキストを {} として読みました。",
    "Only {} rows have both a depth and a force; a fit needs at least {}.": (
        "深さと力がそろった行が {} 行しかありません。当てはめには少なくとも {} 行が必要です。"
    ),
    "{} of {} rows have no depth or no force and were left out.": "{1} 行のうち、深さか力のない {0} 行を除きました。",
    "{} was taken; {} says the same.": "{} を使いました。{} も同じ内容です。",
    "No single column is called “{}”. Give its number, 1 to {}.": (
        "“{}” という列が一つに決まりません。1 から {} の番号で指定してください。"
    ),
    "no numbers": "数がなく",
    "numbers in {} of {} rows only": "{1} 行中 {0} 行しか数がなく",
    "Column {} ({}) holds {}, so it cannot be the {}.": "{} 列目（{}）には {}、{}にできません。",
    "{} cannot be both the depth and the force.": "{} を深さと力の両方にはできません。",
    "The table has one column of numbers; it needs a depth and a force.": (
        "表に数の列が一つしかありません。深さと力が必要です。"
    ),
    "The rows stand from the last to the first by {}; they were turned round.": (
        "{} によると行は最後から最初の順なので、逆にしました。"
    ),
    "“{}” does not run like a clock: the headers may stand over the wrong columns.": (
        "“{}” が時計のように進みません。見出しの列がずれているかもしれません。"
    ),
    "Which column is the {}?": "{}の列はどれですか？",
    "{}, ... from {} to {}": "{}、... {} から {} まで",
    "Eqs. (9) and (10): a simply supported beam of section A and Young's modulus E; k = 2 A E / l follows from "
    "these alone and says nothing about the measured curve.": (
        "式 (9)、(10)：断面積 A、ヤング率 E の単純支持梁。k = 2 A E / l はこれらだけで決まり、測定した曲線とは関係"
        "しません。"
    ),
    "Force balance of a string of length l pressed in its middle: all of the force is carried by the surface, none "
    "by what is inside, and k is the slope of its tension over its stretch; an upper bound of what the surface "
    "adds.": (
        "中央を押した長さ l の弦の力のつり合い：力はすべて表面が受け持ち、内部は受け持たないとして、k は伸びに対す"
        "る張力の傾きです。表面の寄与の上限になります。"
    ),
    "The length of the object must be greater than 0 mm (it is {}).": (
        "物体の長さは 0 mm より大きくしてください（現在 {}）。"
    ),
    "There is no table in this file: no run of rows with two or more numbers.": (
        "このファイルに表がありません。2 つ以上の数が並ぶ行が続いていません。"
    ),
    "There is no table {} in this file: it has {}.": "このファイルに {} 番目の表はありません。表は {} 個です。",
    "Of {} rows one in {} was read.": "{} 行から {} 行に 1 行を読みました。",
    "{} of {} rows have another number of cells and were left out.": (
        "{1} 行のうち、セルの数が違う {0} 行を除きました。"
    ),
    "The table has {} rows; a fit needs at least {}.": "表が {} 行です。当てはめには少なくとも {} 行が必要です。",
    "“{}” is not a unit of {}. Use one of {}.": "“{}” は{}の単位ではありません。{} のいずれかを使ってください。",
    "Counts were divided by {}, as the file says, to get {}.": (
        "ファイルの記述に従い、カウントを {} で割って {} にしました。"
    ),
    "counts of {}/{}": "{}/{} のカウント",
    "The unit of {} changes within the file; each row was converted by its own.": (
        "{} の単位がファイルの途中で変わります。行ごとの単位で換算しました。"
    ),
    "{}: {} was taken as a force, the weight of that mass.": "{}: {} を、その質量の重さ（力）とみなしました。",
    "column {}": "{} 列目",
    "In what unit is {}? It reaches {}.": "{} の単位は何ですか？最大 {} です。",
    "then it reaches {} N": "最大 {} N になります",
    "then it reaches {} mm": "最大 {} mm になります",
    "{}; {}": "{}、{}",
}
