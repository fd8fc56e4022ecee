"""Plans for the sensory comparison: all chance is here, and the extension only goes through a list of trials.

Objects follow a Latin square over the participants, its rows forwards and then backwards. Which comes first, the real
object or the virtual one, the test or the standard, is balanced for each stimulus.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any, Final

KINDS: Final = ("rating", "pairs")
PAPER: Final = ("object_1_nylon_air", "object_2_vinyl_air", "object_3_vinyl_water")
CONSENT: Final = (
    "You will press soft objects and say how they feel. A haptic device may push your fingers with up to 10 N; it does "
    "so only while you hold the key, and Esc stops at any time, without a reason. Answers and forces are kept under a "
    "code, not under your name."
)
INSTRUCTION: Final = "Press each object several times with one finger, gently, as you would test a fruit. Then answer."
STEPS: Final = ("Different", "Slightly Alike", "Alike", "The Same")  # ours: the paper names none of its four
LEVELS: Final = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3)  # two or three just-noticeable differences to either side
EASY: Final = (0.55, 1.55)  # levels that everybody tells from 1
FOIL: Final = 0.6  # of the level: a twin that is too soft
ROUNDS: Final = 4  # of the ratings
REPEATS: Final = 20  # of each level
BLOCK_S: Final = 60.0  # [s] rest between two blocks
Trials = list[dict[str, Any]]


def make(
    kind: str, *, participants: int = 8, seed: int = 1, objects: Sequence[str] = (), real: bool = False
) -> dict[str, Any]:
    """Return a plan as its file states it.

    Args:
        kind: one of KINDS.
        participants: how many; they are P01, P02...
        seed: of all chance.
        objects: presets or materials; of a pair, the first.
        real: the standard of a pair is the real object, and not the virtual one with its constants.
    """
    objects = list(objects) or list(PAPER if kind == "rating" else PAPER[1:2])
    labels = {chr(ord("A") + i): name for i, name in enumerate(objects)}
    if kind != "rating":
        labels = {"A": objects[0], "S": objects[0]}
    people, codes = {}, [f"P{i:02d}" for i in range(1, participants + 1)]
    for i, code in enumerate(codes):
        dice = random.Random(f"{seed} {code}")
        if kind == "rating":
            people[code] = _ratings(list(labels), i, dice)
        else:
            people[code] = _pairs({"real": "A"} if real else {"object": "S"}, dice)
    return {
        "consent": CONSENT, "instruction": INSTRUCTION,
        "question": "How like the real object is the virtual one?" if kind == "rating" else "Which was stiffer?",
        "answers": list(STEPS) if kind == "rating" else ["First", "Second"],
        "exposure_s": 2.0, "trial_s": 25.0 if kind == "rating" else 15.0, "press_n": 4.0, "objects": labels,
        "made": {"kind": "rating" if kind == "rating" else "pair", "seed": seed, "standard": "S"},
        "participants": people,
    }  # fmt: skip


def _ratings(labels: list[str], row: int, dice: random.Random) -> Trials:
    """Return the ratings of a participant: each round has every real object with its twin, and with two foils."""
    count, turn = len(labels), 1 if row // len(labels) % 2 == 0 else -1
    order = [labels[(row + turn * k) % count] for k in range(count)]
    trials: Trials = [
        {"part": "practice", "show": [{"real": order[0]}, {"object": order[0]}]},
        {"part": "practice", "show": [{"object": order[-1], "level": EASY[0]}, {"real": order[-1]}]},
    ]  # fmt: skip
    turned = {(real, i): dice.random() < 0.5 for real in labels for i in range(3)}
    for number in range(ROUNDS):
        block: Trials = []
        for place, real in enumerate(order[number % count :] + order[: number % count]):
            other = labels[(labels.index(real) + 1 + number % max(count - 1, 1)) % count]
            stimuli: Trials = [{"object": real}, {"object": other}, {"object": real, "level": FOIL}]
            if other == real:
                stimuli.pop(1)
            shown: Trials = []
            for i, stimulus in enumerate(stimuli):
                turned[real, i] = not turned[real, i]
                shown.append({"show": [stimulus, {"real": real}] if turned[real, i] else [{"real": real}, stimulus]})
            dice.shuffle(shown)
            block += shown
            if place == number % count:
                easy = {"object": real, "level": EASY[0]}
                block.append({"part": "catch 1 2", "show": [{"real": real}, easy]})
        if number:
            block[0]["rest_s"] = BLOCK_S
        trials += block
    return trials


def _pair(test: dict[str, Any], standard: dict[str, Any], first: bool, **more: Any) -> dict[str, Any]:
    return {**more, "show": [test, standard] if first else [standard, test]}


def _easy(standard: dict[str, Any], dice: random.Random, *, catch: bool) -> dict[str, Any]:
    stiffer, first = dice.random() < 0.5, dice.random() < 0.5
    part = f"catch {1 if first == stiffer else 2}" if catch else "practice"
    return _pair({"object": "A", "level": EASY[stiffer]}, standard, first, part=part)


def _pairs(standard: dict[str, Any], dice: random.Random) -> Trials:
    """Return pairs in blocks, each with every level twice: once first and once second."""
    trials = [_easy(standard, dice, catch=False) for _ in range(4)]
    for number in range(REPEATS // 2):
        block = [_pair({"object": "A", "level": level}, standard, first) for level in LEVELS for first in (True, False)]
        dice.shuffle(block)
        if number % 2:
            block.insert(dice.randrange(1, len(block)), _easy(standard, dice, catch=True))
        elif number:
            block[0]["rest_s"] = BLOCK_S
        trials += block
    return trials
