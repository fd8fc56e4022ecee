"""Japanese of the presets of everyday objects and where their numbers come from."""

_RUBBER = (
    "Data sheet of Smooth-On: stress at 100 % strain {psi} psi; K = 8 a E / 3 for a flat punch of 5 mm, {low} to "
    "{high} N/mm if E may be 20 % off (our guess)"
)
_RUBBER_JA = (
    "Smooth-On のデータシート：100 % 伸びの応力 {psi} psi。半径 5 mm の平面圧子で K = 8 a E / 3。"
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


def _rubber(psi: str, low: str, high: str) -> tuple[str, str]:
    return _RUBBER.format(psi=psi, low=low, high=high), _RUBBER_JA.format(psi=psi, low=low, high=high)


WORDS = {
    "From Rules and Data Sheets": "規則とデータシートから",
    "Made Up": "仮の値",
    "Tennis ball": "テニスボール",
    "ITF Rules of Tennis, Appendix I, type 2: 5.6 to 7.4 mm under 80.07 N between plates, so 10.8 to 14.3 N/mm; 56.0 "
    "to 59.4 g": (
        "ITF テニス規則 付則 I、タイプ 2：板の間で 80.07 N のとき 5.6〜7.4 mm、つまり 10.8〜14.3 N/mm。56.0〜59.4 g"
    ),
    "Squash ball, double yellow dot": "スカッシュボール、ダブルイエロー",
    "Made up: no measurement stands behind it, only the feel of such an object in the hand; but the rules say 39.5 to "
    "40.5 mm across and 23 to 25 g": (
        "仮の値：測定はなく、手に持った感触だけによります。ただし規則では直径 39.5〜40.5 mm、23〜25 g"
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
    "Silicone Ecoflex 00-10, 50 mm": "シリコーン Ecoflex 00-10、50 mm",
    "Silicone Ecoflex 00-30, 50 mm": "シリコーン Ecoflex 00-30、50 mm",
    "Silicone Dragon Skin 10, 50 mm": "シリコーン Dragon Skin 10、50 mm",
    **dict([_rubber("8", "0.59", "0.88"), _rubber("10", "0.74", "1.1"), _rubber("22", "1.6", "2.4")]),
    "Sofa foam, 380 mm": "ソファーのフォーム、380 mm",
    _FOAM.format(kind="sofa seats", pounds="25 to 30", range="4.45 to 5.34"): (
        _FOAM_JA.format(kind="ソファー座面", pounds="25〜30", range="4.45〜5.34")
    ),
    "Office chair foam, 380 mm": "事務椅子のフォーム、380 mm",
    _FOAM.format(
        kind="medium firm to very firm foam, as we take chairs to have", pounds="35 to 45", range="6.23 to 8.01"
    ): _FOAM_JA.format(kind="やや硬め〜非常に硬いフォーム（椅子用とみなす）", pounds="35〜45", range="6.23〜8.01"),
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
