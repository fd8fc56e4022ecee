"""Japanese of the choice of a material, of everyday objects and where their numbers come from."""

_RUBBER = (
    "Data sheet of Smooth-On, {brand}: stress at 100 % strain {psi} psi; K = 8 a E / 3 for a flat punch of 5 mm, {low} "
    "to {high} N/mm if E may be 20 % off (our guess)"
)
_RUBBER_JA = (
    "Smooth-On {brand} のデータシート：100 % 伸びの応力 {psi} psi。半径 5 mm の平面圧子で K = 8 a E / 3。"
    "E の誤差を 20 % とみて {low}〜{high} N/mm（当方の推定）"
)
_FOAM = (
    "Indentation force deflection of {kind} (ASTM D3574, plate of 50 square inches): {pounds} lbf at 25 % of 100 mm, "
    "so {range} N/mm; support factor taken as 2"
)
_FOAM_JA = (
    "{kind}の押し込み硬さ (ASTM D3574、50 平方インチの板)：100 mm の 25 % で {pounds} lbf、つまり {range} N/mm。"
    "サポートファクターは 2 とします"
)


def _rubber(brand: str, psi: str, low: str, high: str) -> tuple[str, str]:
    values = {"brand": brand, "psi": psi, "low": low, "high": high}
    return _RUBBER.format(**values), _RUBBER_JA.format(**values)


_FLESH = (
    "Isogai and others 2022, J. Phys. Ther. Sci. 34, 777: {}, {} kPa; Hertz with a ball of 10 mm, so {} N/mm up to the "
    "knee"
)
_FLESH_JA = (
    "Isogai ほか 2022、J. Phys. Ther. Sci. 34, 777：{}、{} kPa。半径 10 mm の球のヘルツの式で、折れ点まで {} N/mm"
)

WORDS = {
    "Custom": "カスタム",
    "Constants that are typed in or measured": "入力または測定した定数",
    "Tennis ball": "テニスボール",
    "ITF Rules of Tennis, Appendix I, type 2: 5.6 to 7.4 mm under 80.07 N between plates, so 10.8 to 14.3 N/mm; 56.0 "
    "to 59.4 g": (
        "ITF テニス規則 付則 I、タイプ 2：板の間で 80.07 N のとき 5.6〜7.4 mm、つまり 10.8〜14.3 N/mm。56.0〜59.4 g"
    ),
    "Squash ball": "スカッシュボール",
    "Made up: no measurement stands behind it, only the feel of such an object in the hand; but the rules of a "
    "double yellow dot say 39.5 to 40.5 mm across and 23 to 25 g": (
        "仮の値：測定はなく、手に持った感触だけによります。ただしダブルイエローの規則では直径 39.5〜40.5 mm、23〜25 g"
    ),
    "Volleyball": "バレーボール",
    "FIVB rule 3: 65 to 67 cm round, 0.30 to 0.325 kgf/cm2, 260 to 280 g; K = 2 pi R p, from 19.4 to 21 N/mm, pressed "
    "by a plate": "FIVB 規則 3：円周 65〜67 cm、0.30〜0.325 kgf/cm2、260〜280 g。板で押すと K = 2πRp、19.4〜21 N/mm",
    "Beach volleyball": "ビーチバレーボール",
    "FIVB rules: 66 to 68 cm round, 0.175 to 0.225 kgf/cm2, 260 to 280 g; K = 2 pi R p, from 11.5 to 14.8 N/mm, "
    "pressed by a plate": (
        "FIVB 規則：円周 66〜68 cm、0.175〜0.225 kgf/cm2、260〜280 g。板で押すと K = 2πRp、11.5〜14.8 N/mm"
    ),
    "Football": "サッカーボール",
    "Laws of the Game, law 2: 68 to 70 cm round, 0.6 to 1.1 atmospheres, 410 to 450 g; K = 2 pi R p, from 42 to 77 "
    "N/mm, pressed by a plate": (
        "競技規則 第 2 条：円周 68〜70 cm、0.6〜1.1 気圧、410〜450 g。板で押すと K = 2πRp、42〜77 N/mm"
    ),
    "Silicone 00-10": "シリコーン 00-10",
    "Silicone 00-30": "シリコーン 00-30",
    "Silicone 10 A": "シリコーン 10 A",
    **dict([
        _rubber("Ecoflex 00-10", "8", "0.59", "0.88"), _rubber("Ecoflex 00-30", "10", "0.74", "1.1"),
        _rubber("Dragon Skin 10", "22", "1.6", "2.4"),
    ]),
    "Sofa foam": "ソファーのフォーム",
    _FOAM.format(kind="sofa seats", pounds="25 to 30", range="4.45 to 5.34"): (
        _FOAM_JA.format(kind="ソファー座面", pounds="25〜30", range="4.45〜5.34")
    ),
    "Chair foam": "椅子のフォーム",
    _FOAM.format(
        kind="medium firm to very firm foam, as we take chairs to have", pounds="35 to 45", range="6.23 to 8.01"
    ): _FOAM_JA.format(kind="やや硬め〜非常に硬いフォーム（椅子用とみなす）", pounds="35〜45", range="6.23〜8.01"),
    "Skin and fat": "皮膚と脂肪",
    _FLESH.format("subcutaneous tissue of the seat under 1 N", "26.1 ± 19", "0.13 to 0.85"): _FLESH_JA.format(
        "臀部の皮下組織、1 N", "26.1 ± 19", "0.13〜0.85"
    ),
    "Flesh": "肉",
    _FLESH.format("relaxed muscle of the seat under 5 N", "62.2 ± 10.3", "0.97 to 1.4"): _FLESH_JA.format(
        "臀部の力を抜いた筋肉、5 N", "62.2 ± 10.3", "0.97〜1.4"
    ),
    "Jelly": "ゼリー",
    "Bloom test of gelatin (6.67 % in water, 10 °C, a flat plunger of 12.7 mm, 4 mm deep): 175 to 225 g, so 0.429 to "
    "0.552 N/mm; a dessert takes less gelatin": (
        "ゼラチンのブルーム試験 (6.67 % 水溶液、10 °C、直径 12.7 mm の平面圧子、深さ 4 mm)：175〜225 g、つまり "
        "0.429〜0.552 N/mm。デザートではゼラチンがもっと少なくなります"
    ),
    "Bread dough": "パン生地",
    "Party balloon": "風船",
    "Kitchen sponge": "台所用スポンジ",
    "Pillow": "枕",
    "Marshmallow": "マシュマロ",
    "Hot-water bottle": "湯たんぽ",
    "Stress ball": "ストレスボール",
    "Made up: no measurement stands behind it, only the feel of such an object in the hand": (
        "仮の値：測定はなく、手に持った感触だけによります"
    ),
}
