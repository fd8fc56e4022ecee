"""Japanese of the panel on speed and accuracy."""

WORDS = {
    "Speed and Accuracy": "速さと精度",
    "Simulate": "計算するもの",
    "What is simulated: the full mesh or a proxy": "計算するもの。元のメッシュ、またはプロキシ",
    "Automatic": "自動",
    "The full mesh, subdivided where it is coarse, or the finest proxy that runs live": (
        "リアルタイムで動くなら元のメッシュ、動かないならリアルタイムで動く最も細かいプロキシ。粗すぎるメッシュは細分化します"
    ),
    "Full Mesh": "元のメッシュ",
    "Every vertex of the mesh is simulated and no more, however slow or coarse that is": (
        "どれほど遅くても粗くても、メッシュの頂点だけをすべて計算します"
    ),
    "Proxy": "プロキシ",
    "A coarser body is simulated in place of the mesh and deforms it": (
        "粗い物体をメッシュの代わりに計算し、それに合わせてメッシュを変形します"
    ),
    "Approximate number of vertices of the proxy": "プロキシのおよその頂点数",
    "Simulation Share (%)": "計算の割合 (%)",
    "Share of the processor time that the simulation of all bodies may use; Blender needs the rest to draw": (
        "すべての物体の計算が使ってよい処理時間の割合。残りは Blender の描画に必要です"
    ),
    "Plan Key": "計画の鍵",
    "Checksum of everything the plan depends on; a new plan is made when it differs": (
        "計画の前提のチェックサム。変わると計画し直します"
    ),
    "Planned Vertices": "計画の頂点数",
    "Of the proxy; 0 is the full mesh": "プロキシの頂点数。0 は元のメッシュ",
    "Plan": "計画",
    "What is simulated, and why": "何を計算するか、そしてその理由",
}
