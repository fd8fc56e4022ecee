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
    "Move Apart": "引き離す",
    "Where the body intersects something at the start, it is moved out as a whole by the shortest way, "
    "or pressed flat towards its pins; where it passes through itself, those faces are left out of Self Contact; "
    "otherwise that is refused": (
        "開始時に物体が何かと交差していれば、物体全体を最短の向きに動かして離すか、固定部分に向けて押しつぶします。"
        "自分自身と交差する面は、自己接触から外します。"
        "オフのときは、交差があれば開始できません"
    ),
}
