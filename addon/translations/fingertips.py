"""Japanese of fingertips that are animated."""

WORDS = {
    "Add Fingertip": "指先を追加",
    "Key This Press": "この押し方をキーフレームに",
    "Add a fingertip to animate: on top of the active body, or at the 3D cursor if that is on its surface. "
    "Drag its arrow, or move it like any object, and press I over the viewport to keyframe it": (
        "アニメーションさせる指先を追加します。アクティブな物体の頂上か、3D カーソルが表面にあればその位置に置きます。"
        "矢印をドラッグするか、ほかのオブジェクトと同じように動かし、ビューポート上で I を押してキーフレームを付けます"
    ),
    "Turn the last press by mouse, pen or haptic device into a keyframed fingertip, from the current frame on. "
    "Baked, it gives the motion that was seen": (
        "マウス、ペン、力覚デバイスで最後に押した動きを、現在のフレームから始まるキーフレーム付きの指先にします。"
        "ベイクすると、見たとおりの動きになります"
    ),
    "Press a body first: there is nothing to keyframe": "先に物体を押してください。キーフレームにするものがありません",
    "Presses": "押す物体",
    "The body that this fingertip was made for. While the fingertip is active, Bake and Export take that body": (
        "この指先が作られたときの物体。指先がアクティブなとき、ベイクとエクスポートはその物体を対象にします"
    ),
    "Radius of the fingertip of the tool and of those that are added, at the physical size of the body": (
        "ツールの指先と、これから追加する指先の、物体の実物の大きさでの半径"
    ),
}
