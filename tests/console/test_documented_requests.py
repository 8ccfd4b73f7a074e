"""The requests that the how-tos of maps, places and routes print, sent as they stand there."""

import io
import re
import shlex
import urllib.parse
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.console.live import Live, Reply

HOW_TO = Path(__file__).resolve().parents[2] / "static" / "docs" / "how-to"
FENCE = re.compile(r"```sh\n(.*?)```", re.DOTALL)
SETTLED_S = 60.0
JOINING_PATHS = ("/api/maps/match", "/api/maps/join")  # two maps of two drives: benchmarks.join_maps


def printed(page: str) -> Iterator[list[str]]:
    """The arguments of every `curl` on a page."""
    for fence in FENCE.findall((HOW_TO / f"{page}.md").read_text()):
        for line in fence.replace("\\\n", " ").splitlines():
            if line.strip().startswith("curl "):
                yield shlex.split(line)[1:]


def sent(live: Live, arguments: list[str], files: dict[str, bytes]) -> Reply:
    """Send one of them as curl would; what it keeps goes into `files`."""
    headers, body, kept, url, method = dict[str, str](), None, "", "", ""
    rest = iter(arguments)
    for one in rest:
        if one == "-H":
            name, _, value = next(rest).partition(": ")
            headers[name] = value.replace("$KEY", live.operator).replace("$TOKEN", live.operator)
        elif one == "-X":
            method = next(rest)
        elif one == "-d":
            body = next(rest).encode()
        elif one == "--data-binary":
            body = files[next(rest).removeprefix("@")]
        elif one == "-o":
            kept = next(rest)
        else:
            url = one
    parts = urllib.parse.urlsplit(url)
    method = method or ("GET" if body is None else "POST")
    answer = live.ask(method, f"{parts.path}?{parts.query}", raw=body, headers=headers)
    if kept:
        files[kept] = answer.body
    return answer


def zipped(box: zipfile.ZipFile, stem: str) -> bytes:
    """The YAML and the picture of one map of a zip, as a zip."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as alone:
        for name in box.namelist():
            if name.startswith(f"{stem}."):
                alone.writestr(name, box.read(name))
    return packed.getvalue()


@pytest.mark.campaign
def test_every_printed_request_is_answered(tmp_path: Path) -> None:
    files, count = dict[str, bytes](), 0
    with Live(tmp_path) as live:
        live.until(lambda: not live.runtime.snapshot.slam.looking_around, SETTLED_S)
        for name, kind in (("hole", "keep_out"), ("calm", "slow")):
            zone = {"name": f"my {name}", "kind": kind, "points_m": [[2.0, 2.0], [2.2, 2.0], [2.2, 2.2]]}
            zone["max_speed_m_s"] = 0.1 if kind == "slow" else None
            assert live.ask("POST", "/api/zones", zone, token=live.operator).status == 201
        files["office.zip"] = live.ask("GET", "/api/map", token=live.operator).body
        for page in ("save-and-reload-a-map", "name-places-and-zones", "edit-a-map"):
            for arguments in (one for one in printed(page) if not one[-1].endswith(JOINING_PATHS)):
                answer = sent(live, arguments, files)
                assert answer.status in (200, 201, 202), (page, arguments, answer.body[:300])
                count += 1
                if "masks.zip" in arguments:
                    with zipfile.ZipFile(io.BytesIO(answer.body)) as box:
                        files["keepout.zip"], files["speed.zip"] = (
                            zipped(box, f"{kind}_mask") for kind in ("keepout", "speed")
                        )
    assert count >= 9
