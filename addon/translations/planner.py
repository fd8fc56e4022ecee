"""Japanese of what moves in place of a mesh, and of the comparison of methods."""

OPERATORS = {
    "Compare Methods": "手法を比較",
    "Use This": "これを使う",
}

WORDS = {
    "Speed and Accuracy": "速さと精度",
    "What Moves": "動かすもの",
    "What is simulated in place of the mesh": "メッシュの代わりに計算するもの",
    "Automatic": "自動",
    "The mesh itself where that runs live, else the smallest stand-in within the tolerances": (
        "実時間で動くならメッシュそのもの、動かないなら許容差に収まる最小の代役"
    ),
    "Mesh Itself": "メッシュそのもの",
    "Every vertex moves by itself, however slow that is": "どれほど遅くても、すべての頂点がそれぞれ動きます",
    "Stand-In": "代役",
    "A coarser body moves in place of the mesh and carries its skin along": (
        "粗い物体がメッシュの代わりに動き、その表面を運びます"
    ),
    "About how many vertices the stand-in has": "代役のおよその頂点数",
    "Skin Within (mm)": "表面の許容差 (mm)",
    "How far the skin of a dent may lie from where the mesh itself would have it (root of mean square)": (
        "くぼみの表面が、メッシュそのものの場合からどれだけ離れてよいか (二乗平均平方根)"
    ),
    "Force Within (%)": "力の許容差 (%)",
    "How much the force may differ from that of the mesh itself": "力がメッシュそのものの場合とどれだけ違ってよいか",
    "Simulation Share (%)": "計算の割合 (%)",
    "How much of every second the simulation of all bodies may take; the rest is Blender's, to draw": (
        "すべての物体の計算が 1 秒のうちどれだけ使ってよいか。残りは Blender の描画に使います"
    ),
    "Plan Key": "計画の鍵",
    "What the choice hangs on: when it changes, a new one is made": "選択の前提。変わると選び直します",
    "Planned Vertices": "計画の頂点数",
    "Of the stand-in; 0 is the mesh itself": "代役の頂点数。0 はメッシュそのもの",
    "Plan": "計画",
    "What moves, and why": "何が動くか、そしてその理由",
    "Comparison": "比較",
    "What every way to simulate this object came to": "この物体の計算方法それぞれの結果",
    "Show Comparison": "比較を表示",
    "Draw the comparison of the active object over the viewport": "アクティブな物体の比較をビューポートに描きます",
    "Press the active object virtually on proxies of several sizes, and chart their cost against their error": (
        "アクティブな物体をいくつかの大きさの代理メッシュで仮想的に押し、費用と誤差を図にします"
    ),
    "Presses": "押す回数",
    "How many places are pressed: more take longer and tell more": "押す場所の数。多いほど時間がかかり、よく分かります",
    "Simulate the active object this way from now on": "これからアクティブな物体をこの方法で計算します",
    "Comparing: Esc cancels": "比較中: Esc で中止",
    "The body or the fingertip was changed since: compare again": (
        "物体か指先がその後変更されました。もう一度比較してください"
    ),
    "Live": "実時間",
    "Error (mm) against cost (s of computing a second)": "誤差 (mm) と費用 (1 秒あたりの計算秒)",
}
