"""Teaching the robot who someone is, by pictures from anywhere, and to whom alone it comes."""

import struct
import zlib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import cv2
import numpy as np
import pytest

from console.people.service import EnrollmentService
from tests.console.live import Live, Reply
from tests.console.people_pictures import png

PNG = {"Content-Type": "image/png"}


@pytest.fixture
def school(live: Live) -> Iterator[Live]:
    """A console that knows nobody, before and after."""

    def forget() -> None:
        for one in live.ask("GET", "/api/people", token=live.viewer).json["people"]:
            live.ask("DELETE", f"/api/people/{one['id']}", token=live.operator)

    forget()
    yield live
    forget()


def begin(live: Live) -> str:
    begun = live.ask("POST", "/api/people", token=live.operator)
    assert begun.status == 201 and begun.json["next"] == "" and "without anybody" in begun.json["advice"]
    return f"/api/people/{begun.json['id']}"


def send(live: Live, path: str, raw: bytes, **headers: str) -> Reply:
    told = {**PNG, **{name.replace("_", "-"): value for name, value in headers.items()}}
    return live.ask("POST", path, raw=raw, token=live.operator, headers=told)


def test_someone_is_learnt_from_pictures_that_are_judged_in_words(school: Live) -> None:
    path = begin(school)
    early = send(school, f"{path}/pictures", png("down"))
    assert early.status == 409 and "background" in early.json["detail"]
    assert send(school, f"{path}/background", png("empty")).json["next"] == "down"

    wrong = {"empty": "Nobody is in the picture", "near": "cut off", "dark": "too dark", "moved": "background"}
    for name, words in wrong.items():
        told = send(school, f"{path}/pictures", png(name)).json
        assert not told["newest"]["good"] and words in told["newest"]["words"], name
        assert told["pictures"] == []

    first = school.ask("GET", f"{path}/pictures/1.jpg", token=school.operator)
    assert first.body.startswith(b"\xff\xd8\xff"), "a slow page still gets what it asks for"
    with ThreadPoolExecutor(4) as hands:
        sent = list(hands.map(lambda _: send(school, f"{path}/pictures", png("down")), range(4)))
    assert {one.status for one in sent} <= {200, 429}
    told = school.ask("GET", "/api/people", token=school.operator).json["enrollment"]
    assert len(told["pictures"]) == 1 and told["next"] == "out", "one picture, however often it comes at once"
    told["newest"] = told["pictures"][0]
    assert [part["name"] for part in told["newest"]["parts"]] == ["head", "torso", "feet"]
    (head, torso, feet) = (part["box_px"] for part in told["newest"]["parts"])
    assert head[1] < torso[1] < feet[1] < told["newest"]["size"][1] and len(told["newest"]["outline"]) > 8
    again = send(school, f"{path}/pictures", png("again")).json["newest"]
    assert not again["good"] and "too like" in again["words"]

    short = school.ask("POST", f"{path}/finish", {"name": "Ann"}, token=school.operator)
    assert short.status == 409 and "at least 3" in short.json["detail"]
    for name in ("out", "wave", "side"):
        told = send(school, f"{path}/pictures", png(name)).json
        assert told["newest"]["good"], told["newest"]["words"]
    assert told["ready"] and told["next"] == "" and len(told["pictures"]) == 4
    number = told["pictures"][0]["number"]
    shown = school.ask("GET", f"{path}/pictures/{number}.jpg", token=school.operator)
    assert shown.status == 200 and shown.body.startswith(b"\xff\xd8\xff")
    assert school.ask("GET", f"{path}/pictures/{number}.jpg", token=school.viewer).status == 403
    dropped = school.ask("POST", f"{path}/pictures/{number}/drop", token=school.operator).json
    assert dropped["next"] == "down" and len(dropped["pictures"]) == 3

    assert school.ask("POST", f"{path}/finish", {"name": " \u0007 "}, token=school.operator).status == 422
    done = school.ask("POST", f"{path}/finish", {"name": "  Ann  "}, token=school.operator)
    assert done.status == 201 and done.json["name"] == "Ann"
    assert school.ask("GET", f"{path}/pictures/{number}.jpg", token=school.operator).status == 404
    told = school.ask("GET", "/api/people", token=school.viewer).json
    assert [one["name"] for one in told["people"]] == ["Ann"] and told["enrollment"] is None

    folder = school.runtime.parts[EnrollmentService].person_store.folder
    (file,) = folder.glob(f"{done.json['id']}*")
    assert file.stat().st_size < 3000, "numbers, no pictures"


def test_pictures_from_strangers_break_nothing(school: Live) -> None:
    path = begin(school)
    send(school, f"{path}/background", png("empty"))
    send(school, f"{path}/pictures", png("down"))
    chunk = b"IHDR" + struct.pack(">IIBBBBB", 20000, 20000, 8, 2, 0, 0, 0)
    header = struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))
    hostile = {
        "nothing": b"",
        "words": b"hello",
        "announces 400 Mpx": b"\x89PNG\r\n\x1a\n" + header + b"\0\0\0\0IEND\xaeB`\x82",
        "cut off": png("down")[:5000],
        "damaged": png("down")[:200] + bytes(4000) + png("down")[4200:],
        "tiny": cv2.imencode(".png", np.zeros((8, 8, 3), np.uint8))[1].tobytes(),
        "a bitmap": cv2.imencode(".bmp", np.zeros((80, 80, 3), np.uint8))[1].tobytes(),
    }
    for what, raw in hostile.items():
        for where in ("pictures", "background"):
            answer = send(school, f"{path}/{where}", raw)
            assert answer.status in (400, 422), (what, where, answer.status)
            assert answer.json["detail"].endswith("."), what
    other = cv2.imencode(".png", np.full((300, 300, 3), 99, np.uint8))[1].tobytes()
    assert "different size" in send(school, f"{path}/pictures", other).json["newest"]["words"]
    assert send(school, f"{path}/pictures", png("down"), Content_Type="text/html").status == 415
    assert send(school, f"{path}/pictures", png("down"), Content_Type="application/json").status == 415
    assert send(school, f"{path}/pictures", b"\xff\xd8\xff" + bytes(20_000_001)).status == 413
    assert send(school, "/api/people/0123456789ab/pictures", png("down")).status == 404
    told = school.ask("GET", "/api/people", token=school.viewer).json["enrollment"]
    assert told["background"] and len(told["pictures"]) == 1, "nothing was lost"
    assert school.ask("DELETE", path, token=school.operator).status == 204
    assert school.ask("GET", "/api/people", token=school.viewer).json["enrollment"] is None


def test_a_viewer_sees_who_is_known_and_changes_nothing(school: Live) -> None:
    path = begin(school)
    asked: list[tuple[str, str, Any]] = [
        ("POST", "/api/people", None),
        ("POST", f"{path}/capture", {"what": "background"}),
        ("POST", f"{path}/demo", {"on": True}),
        ("POST", f"{path}/finish", {"name": "Eve"}),
        ("POST", f"{path}/rename", {"name": "Eve"}),
        ("PUT", "/api/people/chosen", {"id": None}),
        ("DELETE", path, None),
        ("DELETE", "/api/people/demo", None),
    ]
    for method, where, body in asked:
        assert school.ask(method, where, body, token=school.viewer).status == 403, where
    assert school.ask("GET", "/api/people", token=school.viewer).status == 200
    assert school.ask("DELETE", "/api/people/demo", token=school.operator).status == 204
    assert school.ask("PUT", "/api/people/chosen", {"id": "0123456789ab"}, token=school.operator).status == 404
    assert school.ask("PUT", "/api/people/chosen", {}, token=school.operator).status == 422
