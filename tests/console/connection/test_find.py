"""Search for robots: what answers, and for whom."""

import asyncio
import socket

from console.connection.service import answers
from tests.console.live import Live

HOST, PORT = "127.0.0.9", 8765  # of this computer alone


def test_hosts_that_were_looked_at_are_asked_again_and_what_answers_is_named(live: Live) -> None:
    live.ask("POST", "/api/robot/probe", {"url": f"foxglove://{HOST}:1"}, token=live.admin)
    with socket.create_server((HOST, PORT)):
        answers = live.ask("POST", "/api/robot/find", token=live.admin).json
        assert f"foxglove://{HOST}:{PORT}" in answers["urls"]
        assert {"127.0.0.1:8765", f"{HOST}:{PORT}", f"{HOST}:9090"} <= set(answers["looked_at"])
    answers = live.ask("POST", "/api/robot/find", token=live.admin).json
    assert f"foxglove://{HOST}:{PORT}" not in answers["urls"] and f"{HOST}:{PORT}" in answers["looked_at"]


def test_a_name_that_no_name_service_takes_does_not_answer() -> None:
    assert not asyncio.run(answers("a..b", PORT))


def test_an_operator_learns_nothing_of_this_computer_and_a_viewer_may_not_ask(live: Live) -> None:
    with socket.create_server((HOST, PORT)):
        live.ask("POST", "/api/robot/probe", {"url": f"foxglove://{HOST}:1"}, token=live.operator)
        answers = live.ask("POST", "/api/robot/find", token=live.operator).json
        assert answers == {"urls": [], "looked_at": []}
    assert live.ask("POST", "/api/robot/find", token=live.viewer).status == 403
