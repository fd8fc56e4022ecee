"""Japanese of what bodies meet."""

WORDS = {
    "Contact": "接触",
    "Dimple Collider": "Dimple コライダー",
    "Running bodies meet this object, and each other; nothing passes through them": (
        "動いている物体がこのオブジェクトや互いにぶつかります。物体は何にも突き抜けられません"
    ),
    "Collider Friction": "コライダーの摩擦係数",
    "Coefficient of friction of this object with bodies that touch it; 0 is frictionless": (
        "このオブジェクトと、触れる物体との間の摩擦係数。0 は摩擦なしです"
    ),
    "Falls": "落ちる",
    "The collider is a prop: it falls by its weight and rests on soft bodies, other colliders, other props and the "
    "ground": (
        "コライダーは小道具です。自分の重さで落ち、柔らかい物体、ほかのコライダー、ほかの小道具、地面の上で止まります"
    ),
    "Prop Mass (kg)": "小道具の質量 (kg)",
    "Mass of what falls": "落ちるものの質量",
    "Self Contact": "自己接触",
    "The body does not pass through itself where it folds": "折り重なったところで、物体が自分自身を突き抜けません",
}
