"""Japanese of the panel on speed and accuracy, and of the comparison of proxies."""

OPERATORS = {
    "Compare Proxies": "代理メッシュを比較",
    "Use This": "これを使う",
}

WORDS = {
    "Speed and Accuracy": "速さと精度",
    "Simulate": "計算するもの",
    "What is simulated: the full mesh or a proxy": "計算するもの。元のメッシュ、または代理メッシュ",
    "Automatic": "自動",
    "The full mesh, cut finer where it is coarse, or the smallest proxy within the tolerances": (
        "実時間で動くなら元のメッシュ、動かないなら許容差に収まる最小の代理メッシュ。粗すぎるメッシュは細かく分割します"
    ),
    "Full Mesh": "元のメッシュ",
    "Every vertex of the mesh is simulated and no more, however slow or coarse that is": (
        "どれほど遅くても粗くても、メッシュの頂点だけをすべて計算します"
    ),
    "Proxy": "代理メッシュ",
    "A coarser body is simulated in place of the mesh and deforms it": (
        "粗い物体をメッシュの代わりに計算し、それに合わせてメッシュを変形します"
    ),
    "Approximate number of vertices of the proxy": "代理メッシュのおよその頂点数",
    "Surface Tolerance (mm)": "表面の許容差 (mm)",
    "Allowed root-mean-square distance of the dented surface from that of the full mesh": (
        "くぼみの表面が、元のメッシュの場合からどれだけ離れてよいか (二乗平均平方根)"
    ),
    "Force Tolerance (%)": "力の許容差 (%)",
    "Allowed difference of the force from that of the full mesh": "力が元のメッシュの場合とどれだけ違ってよいか",
    "Simulation Share (%)": "計算の割合 (%)",
    "Share of the processor time that the simulation of all bodies may use; Blender needs the rest to draw": (
        "すべての物体の計算が使ってよい処理時間の割合。残りは Blender の描画に必要です"
    ),
    "Plan Key": "計画の鍵",
    "Checksum of everything the plan depends on; a new plan is made when it differs": (
        "計画の前提のチェックサム。変わると計画し直します"
    ),
    "Plan Cells": "計画の区画",
    "Which vertices move together in a large proxy: it is made sooner from them": (
        "大きな代理メッシュでまとまって動く頂点。これがあれば速く作り直せます"
    ),
    "Plan Cells, Graded": "計画の区画（段階的）",
    "The same of one that is fine where it will be pressed": "押される所の近くで細かいものについての同じもの",
    "Planned Vertices": "計画の頂点数",
    "Of the proxy; 0 is the full mesh": "代理メッシュの頂点数。0 は元のメッシュ",
    "Times Faster": "倍速",
    "How many times faster than slow fingertips it is simulated": "ゆっくり動く指先の何倍の速さで計算するか",
    "Slack (m)": "ゆるみ (m)",
    "Parts of the mesh that move by less rest; 0: all of it is simulated": (
        "これより動かない部分は休ませます。0 ではすべてを計算します"
    ),
    "Graded": "段階的",
    "The proxy is fine where it will be pressed and coarse elsewhere": (
        "代理メッシュは押される所の近くで細かく、ほかでは粗くなります"
    ),
    "Plan": "計画",
    "What is simulated, and why": "何を計算するか、そしてその理由",
    "Comparison": "比較",
    "Cost and errors of every variant of this object": "この物体の各方式の費用と誤差",
    "Show Comparison": "比較を表示",
    "Draw the comparison of the active object over the viewport": "アクティブな物体の比較をビューポートに描きます",
    "Press proxies of the active object virtually, of several sizes, and chart their cost against their error": (
        "アクティブな物体をいくつかの大きさの代理メッシュで仮想的に押し、費用と誤差を図にします"
    ),
    "Presses": "押す回数",
    "Number of places that are pressed; more take longer and are more reliable": (
        "押す場所の数。多いほど時間がかかり、信頼できます"
    ),
    "Simulate the active object with this proxy from now on": "これからアクティブな物体をこの代理メッシュで計算します",
    "Comparing: Esc cancels": "比較中: Esc で中止",
    "The body or the fingertip has changed: compare again": (
        "物体か指先がその後変更されました。もう一度比較してください"
    ),
    "Live": "実時間",
    "Error (mm) against cost (s per second)": "誤差 (mm) と費用 (1 秒あたりの計算秒)",
}
