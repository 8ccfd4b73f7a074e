"""Tokens, logins, and those who guess."""

from console.access.logins import LOGIN_LIFE_S, Logins, Person


def test_a_token_opens_logins_that_are_told_apart() -> None:
    logins = Logins()
    token = logins.issue("operator", "operator")
    one, other = logins.open(token, "", 0.0), logins.open(token, "Anna", 0.0)
    assert one is not None and other is not None
    assert one[0] != other[0] and one[1].id != other[1].id
    assert one[1].name == "operator 1" and other[1].name == "Anna"
    assert logins.of_cookie(one[0], 1.0) == one[1]


def test_a_login_holds_no_token() -> None:
    logins = Logins()
    token = logins.issue("operator", "operator")
    opened = logins.open(token, "", 0.0)
    assert opened is not None
    assert token not in opened[0]
    assert token not in repr(vars(logins))


def test_a_wrong_token_opens_nothing_whatever_it_is_made_of() -> None:
    logins = Logins()
    token = logins.issue("operator", "operator")
    for wrong in ("", token[:-1], token + "x", "é" * 43, "\ud800", "\x00", token.swapcase()):
        assert logins.open(wrong, "", 0.0) is None
        assert logins.bearer(wrong, 0.0) is None


def test_a_token_for_one_login_is_spent_by_it() -> None:
    logins = Logins()
    token = logins.issue("operator", "operator", once=True)
    assert logins.bearer(token, 0.0) is None
    assert logins.open(token, "", 0.0) is not None
    assert logins.open(token, "", 0.0) is None


def test_a_login_ends_after_its_time_and_when_it_is_closed() -> None:
    logins = Logins()
    token = logins.issue("operator", "operator")
    opened, other = logins.open(token, "", 0.0), logins.open(token, "", 1.0)
    assert opened is not None and other is not None
    assert logins.of_cookie(opened[0], LOGIN_LIFE_S) is None
    assert logins.expire(LOGIN_LIFE_S) == [opened[1]]
    logins.close(other[1])
    assert logins.of_cookie(other[0], 2.0) is None


def test_five_wrong_tokens_within_a_minute_block_an_address_and_no_other() -> None:
    logins = Logins()
    for moment in range(5):
        assert not logins.blocked("1.2.3.4", moment)
        logins.guessed("1.2.3.4", moment)
    assert logins.blocked("1.2.3.4", 5.0)
    assert not logins.blocked("1.2.3.5", 5.0)
    assert not logins.blocked("1.2.3.4", 66.0)


def test_a_role_reaches_what_lies_below_it() -> None:
    viewer, operator, admin = (Person("x", "x", role) for role in ("viewer", "operator", "admin"))
    assert viewer.may("viewer") and not viewer.may("operator")
    assert operator.may("viewer") and operator.may("operator") and not operator.may("admin")
    assert admin.may("operator") and admin.may("admin")


def test_another_tab_with_the_same_role_stays_the_same_person() -> None:
    logins = Logins()
    driving, watching = logins.issue("operator", "operator"), logins.issue("viewer", "viewer")
    cookie, person = logins.open(driving, "", 0.0) or ("", None)
    assert logins.open(driving, "", 5.0, cookie) == (cookie, person)
    assert logins.of_cookie(cookie, LOGIN_LIFE_S + 1.0) == person  # it lasts from the newest opening
    other, viewer = logins.open(watching, "", 6.0, cookie) or ("", None)
    assert other != cookie and viewer != person and viewer is not None and viewer.role == "viewer"
    stale = logins.open(driving, "", 2 * LOGIN_LIFE_S, cookie)
    assert stale is not None and stale[0] != cookie
    assert logins.open(driving, "", 0.0, "forged") not in (None, ("forged", person))


def test_two_people_are_never_called_alike() -> None:
    logins = Logins()
    driving, watching = logins.issue("operator", "operator"), logins.issue("viewer", "viewer")
    opened = [logins.open(key, name, 0.0) for key, name in ((driving, "Ann"), (watching, "ANN"), (watching, "Ann"))]
    assert [one[1].name for one in opened if one] == ["Ann", "ANN (2)", "Ann (3)"]


def test_a_token_may_end() -> None:
    logins = Logins()
    token = logins.issue("operator", "operator", once=True, end=100.0)
    assert logins.open(token, "", 100.0) is None
    assert logins.open(token, "", 99.0) is not None
