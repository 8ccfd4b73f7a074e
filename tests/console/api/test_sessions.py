"""Links, keys and logins over HTTP."""

from typing import Any

import pytest

from tests.console.live import Live

HOST = {"Content-Type": "application/json"}


def as_admin(live: Live, method: str, path: str, body: Any = None) -> Any:
    return live.ask(method, path, token=live.admin, body=body)


def test_a_link_signs_in_who_opens_it_and_its_end_signs_out(live: Live) -> None:
    made = as_admin(live, "POST", "/api/links", {"role": "viewer", "name": "tablet"})
    assert made.status == 201
    address = made.json["address"]
    assert address.startswith(f"http://127.0.0.1:{live.port}/#t=") and "--host" in made.json["note"]
    size = len(made.json["qr"])
    assert size >= 21 and {len(row) for row in made.json["qr"]} == {size}
    token = address.partition("#t=")[2]
    opened = live.ask("POST", "/api/login", body={"token": token}, headers={"Sec-Fetch-Site": "same-origin"})
    assert opened.json["name"] == "tablet" and opened.json["role"] == "viewer"
    listed = as_admin(live, "GET", "/api/sessions").json
    assert opened.json["id"] in {row["id"] for row in listed["sessions"]}
    assert token not in str(listed)
    assert as_admin(live, "DELETE", f"/api/keys/{made.json['id']}").status == 204
    assert live.ask("GET", "/api/me", token=token).status == 401
    assert as_admin(live, "DELETE", f"/api/keys/{made.json['id']}").status == 404
    assert as_admin(live, "DELETE", f"/api/sessions/{opened.json['id']}").status == 404, "it went with its key"


def test_a_link_made_behind_a_proxy_leads_below_its_path(live: Live) -> None:
    for path, below in {"/lab/beckon": "lab/beckon/", "//evil.example": "", '/a"b': "", "": ""}.items():
        headers = {"X-Forwarded-Prefix": path, "Content-Type": "application/json"}
        made = live.ask("POST", "/api/links", {"role": "viewer"}, token=live.admin, headers=headers)
        assert made.json["address"].startswith(f"http://127.0.0.1:{live.port}/{below}#t=")


def test_a_login_is_ended_from_elsewhere(live: Live) -> None:
    opened = live.ask("POST", "/api/login", body={"token": live.viewer}, headers={"Sec-Fetch-Site": "same-origin"})
    assert as_admin(live, "DELETE", f"/api/sessions/{opened.json['id']}").status == 204
    cookie = opened.headers["set-cookie"].partition(";")[0]
    assert live.ask("GET", "/api/me", headers={"Cookie": cookie}).status == 401


@pytest.mark.parametrize("role", ["viewer", "operator"])
def test_only_the_administrator_makes_links_and_ends_logins(live: Live, role: str) -> None:
    for method, path, body in (
        ("GET", "/api/sessions", None),
        ("POST", "/api/links", {"role": "viewer"}),
        ("DELETE", "/api/keys/00000000", None),
        ("DELETE", "/api/sessions/000000000000", None),
    ):
        assert live.ask(method, path, token=getattr(live, role), body=body).status == 403
