"""Japanese of the export of animations."""

WORDS = {
    "Export the press of the selected bodies, with a table of forces and a JSON that describes the files": (
        "選択した物体の動きを、力の表とファイルを説明する JSON を添えてエクスポートします"
    ),
    "Where the files go, named after the objects": "ファイルの保存先。ファイル名はオブジェクト名になります",
    "Folder": "フォルダー",
    "Formats": "形式",
    "What to write": "書き出す形式",
    "Alembic (.abc)": "Alembic 形式 (.abc)",
    "For other 3D programs and renderers": "ほかの 3D ソフトやレンダラー用",
    "USD (.usdc)": "USD 形式 (.usdc)",
    "For other 3D programs, renderers and pipelines": "ほかの 3D ソフト、レンダラー、パイプライン用",
    "glTF Binary (.glb)": "glTF バイナリ (.glb)",
    "For game engines and the web, with a morph target for each frame": (
        "ゲームエンジンとウェブ用。フレームごとにモーフターゲットを作ります"
    ),
    "FBX (.fbx)": "FBX 形式 (.fbx)",
    "For game engines, with a shape key for each frame": "ゲームエンジン用。フレームごとにシェイプキーを作ります",
    "PC2 Point Cache (.pc2)": "PC2 ポイントキャッシュ (.pc2)",
    "For 3ds Max, and Blender's Mesh Cache modifier": "3ds Max と Blender のメッシュキャッシュモディファイアー用",
    "MDD Point Cache (.mdd)": "MDD ポイントキャッシュ (.mdd)",
    "For LightWave, Cinema 4D, Houdini, and Blender's Mesh Cache modifier": (
        "LightWave、Cinema 4D、Houdini、Blender のメッシュキャッシュモディファイアー用"
    ),
    "STL Sequence": "STL 連番",
    "A folder with a file for each frame, for printing and simulation": (
        "フレームごとのファイルを収めたフォルダー。3D プリントや計算用"
    ),
    "PLY Sequence": "PLY 連番",
    "A folder with a file for each frame, for scanning tools and numpy": (
        "フレームごとのファイルを収めたフォルダー。スキャン用ソフトや numpy 用"
    ),
    "Vertex Animation Texture": "頂点アニメーションテクスチャ",
    "EXR and 16-bit PNG for shaders, and the mesh with its second UV map": (
        "シェーダー用の EXR と 16 ビット PNG、2 番目の UV マップの付いたメッシュ"
    ),
    "What is exported": "エクスポートするもの",
    "Bake or Recording": "ベイクまたは記録",
    "What the objects play; those that play nothing are simulated": (
        "オブジェクトが再生しているもの。何も再生していなければ計算します"
    ),
    "Simulate Anew": "計算し直す",
    "Simulate the objects as a bake does, whatever they play": (
        "何を再生していても、ベイクと同じようにオブジェクトを計算します"
    ),
    "In formats with shape keys, one for this many frames; the JSON says how far those between are off": (
        "シェイプキーを使う形式で、このフレーム数ごとに一つ作ります。間のフレームのずれは JSON に書きます"
    ),
    "Key Error (%)": "キーの誤差 (%)",
    "In formats with shape keys, few with which no vertex is off by more of the object's size. "
    "0 makes one every n frames": (
        "シェイプキーを使う形式で、頂点のずれがオブジェクトの大きさのこの割合を超えない範囲で、キーを減らします。"
        "0 なら n フレームごとに一つ作ります"
    ),
    "Normals": "ノーマル",
    "Write the normals that shade the surface; files are larger": "表面の陰影も書き出します。ファイルは大きくなります",
    "Overwrite": "上書き",
    "Replace files that are there already": "すでにあるファイルを置き換えます",
    "Curves": "カーブ",
    "Keyframe force, depth and pressure as custom properties, for drivers": (
        "力、深さ、圧力をドライバー用のカスタムプロパティとしてキーフレームにします"
    ),
    "{} frames, about {} MB": "{} フレーム、約 {} MB",
    ", {} on this computer": "、このコンピューターで {}",
    "USD Blend Shapes (.usdc)": "USD ブレンドシェイプ (.usdc)",
    "Smaller with few shape keys, for programs that read UsdSkel": (
        "シェイプキーが少なければ小さくなります。UsdSkel を読むソフト用"
    ),
    "The bakes of these objects would be exported as stills:": (
        "次のオブジェクトのベイクは、動かない形としてエクスポートされます:"
    ),
    "File > Export > Dimple Animation writes them as they move.": (
        "「ファイル > エクスポート > Dimple アニメーション」なら動きのまま書き出します。"
    ),
    "Exporting: Esc cancels": "エクスポート中：Esc で中止",
    "Go back to Object Mode to export": "エクスポートするにはオブジェクトモードに戻ってください",
}
