"""Trust: the lower level wins, reasons of it come first, and none is said twice."""

from __future__ import annotations

import json
from itertools import product

import pytest

from bodyschema.trust.trust import LEVELS, Level, Trust

LIMITED = Trust("limited", ("The halves disagree by 1.2 mm.", "Few rows."))
AGAINST = Trust("contradicted", ("The camera moved at row 40.",))


def test_nothing_against_it_is_good() -> None:
    assert Trust() == Trust("good", ())
    assert Trust().also(Trust()) == Trust()


@pytest.mark.parametrize(("one", "other"), list(product(LEVELS, LEVELS)))
def test_the_lower_level_of_two_is_that_of_both(one: Level, other: Level) -> None:
    lower = LEVELS[max(LEVELS.index(one), LEVELS.index(other))]
    assert Trust(one).also(Trust(other)).level == lower


@pytest.mark.parametrize(("one", "other"), [(LIMITED, AGAINST), (AGAINST, LIMITED)])
def test_the_gravest_reasons_come_first_whichever_was_found_first(one: Trust, other: Trust) -> None:
    assert one.also(other) == Trust("contradicted", (*AGAINST.reasons, *LIMITED.reasons))


def test_reasons_of_equal_level_keep_their_order() -> None:
    more = Trust("limited", ("The joints bend.",))
    assert LIMITED.also(more).reasons == (*LIMITED.reasons, "The joints bend.")
    assert more.also(LIMITED).reasons == ("The joints bend.", *LIMITED.reasons)


def test_a_reason_is_said_once() -> None:
    again = Trust("contradicted", ("Few rows.",))
    assert LIMITED.also(again).reasons == ("Few rows.", "The halves disagree by 1.2 mm.")
    assert LIMITED.also(LIMITED) == LIMITED


def test_what_is_good_keeps_its_remarks() -> None:
    assert Trust("good", ("Seen twice.",)).also(LIMITED).reasons[-1] == "Seen twice."


def test_the_document_is_plain() -> None:
    document = LIMITED.document
    assert document == {"level": "limited", "reasons": list(LIMITED.reasons)}
    assert json.loads(json.dumps(document)) == document
