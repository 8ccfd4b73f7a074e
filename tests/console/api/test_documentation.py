"""The description of the interface: every answer by a name, who may ask, and calls that can be copied."""

import json
import re
import shlex
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, get_args

import jsonschema_rs
import msgspec
import pytest

from console.__main__ import main
from console.api.documentation import ADDRESS, UNIONS, DescribedApp, add_schemas, socket_schema
from console.app import ROUTERS
from console.messages import inbound
from tests.console.live import Live, hear
from tests.reference.pages import rest_page
from tests.test_docs import DOCS, FENCE, PAGES


@pytest.fixture(scope="module")
def description() -> Any:
    app = DescribedApp(docs_url=None, redoc_url=None, openapi_url=None)
    for router in ROUTERS:
        app.router.routes.extend(router.routes)
    return app.openapi()


def operations(description: Any) -> list[tuple[str, Any]]:
    return [
        (f"{method} {path}", each)
        for path, methods in description["paths"].items()
        for method, each in methods.items()
    ]


def test_every_answer_has_a_name_and_every_name_a_form(description: Any) -> None:
    schemas, seen = description["components"]["schemas"], 0
    for call, operation in operations(description):
        for status, answer in operation["responses"].items():
            for content in answer.get("content", {}).values():
                shape = content["schema"]
                for part in shape.get("anyOf", [shape]):
                    assert part.get("$ref", "").rpartition("/")[2] in schemas, (call, status, shape)
                    seen += 1
    assert seen > 500


def test_every_call_says_who_may_make_it(description: Any) -> None:
    schemes = description["components"]["securitySchemes"]
    assert set(schemes) == {"key", "login"}
    open_to_all = {call for call, each in operations(description) if not each["security"]}
    assert open_to_all == {"post /api/login", "get /api/health", "get /metrics"}
    for _, each in operations(description):
        assert {name for one in each["security"] for name in one} in (set(), set(schemes))
        assert each["x-role"] in ("public", "viewer", "operator", "admin")


def curls() -> list[list[str]]:
    """The words of every `curl` line of the guides."""
    guides = [page for page in PAGES if page != DOCS / "reference/rest.md"]
    fences = (fence for page in guides for fence in FENCE.findall(page.read_text()))
    lines = (line for fence in fences for line in fence.replace("\\\n", " ").splitlines())
    return [shlex.split(line) for line in lines if line.strip().startswith("curl ")]


@pytest.mark.parametrize("words", curls(), ids=" ".join)
def test_every_call_of_the_guides_is_one_of_the_interface(description: Any, words: list[str]) -> None:
    given = {flag: value for flag, value in pairwise(words) if flag.startswith("-")}
    path, _, query = "/api/{}".format(
        next(word for word in words if "/api/" in word).partition("/api/")[2]
    ).partition("?")
    posts = {"-d", "--data-binary", "--data"} & given.keys()
    method = given.get("-X", "POST" if posts else "GET").lower()
    found = [
        each
        for call, each in operations(description)
        if re.fullmatch(re.sub(r"\\{\w+\\}", "[^/]+", re.escape(call)), f"{method} {path}")
    ]
    assert found, f"{method} {path}"
    named = {one["name"] for one in found[0].get("parameters", [])}
    assert {part.partition("=")[0] for part in query.split("&") if part} <= named
    if "-d" in given and (body := json.loads(given["-d"])):
        shape = found[0]["requestBody"]["content"]["application/json"]["schema"]
        schema = {**shape, "components": description["components"]}
        assert jsonschema_rs.is_valid(schema, body)


def test_every_call_has_a_name_in_words_and_the_refusals_that_occur(description: Any) -> None:
    calls = dict(operations(description))
    names = [each["operationId"] for each in calls.values()]
    assert len(set(names)) == len(names) and all(re.fullmatch(r"[a-z]+(_[a-z0-9]+)+", name) for name in names)
    assert calls["get /api/maps/{name}.zip"]["operationId"] == "get_maps_by_name_zip"
    assert all(" " in each["summary"] for each in calls.values() if each["operationId"] != "post_stop")

    def refusals(call: str) -> set[int]:
        return {int(status) for status in calls[call]["responses"] if status >= "400"}

    body = {400, 401, 403, 408, 413, 415, 422}
    assert refusals("get /api/health") == {403, 503} and refusals("get /api/lease") == {401, 403}
    assert refusals("post /api/commands") == body | {409, 503}
    assert refusals("post /api/login") == body | {429, 507}
    assert refusals("delete /api/maps/{name}") == {401, 403, 404, 409, 422, 429, 503, 507}
    assert refusals("post /api/people/{id}/pictures") == body | {404, 409, 429, 503, 507}


def test_generators_of_clients_find_nothing_that_they_refuse(description: Any) -> None:
    def parts(shape: Any) -> Iterator[Any]:
        yield shape
        for part in shape.values() if isinstance(shape, dict) else shape if isinstance(shape, list) else ():
            yield from parts(part)

    every = [part for part in parts(description) if isinstance(part, dict)]
    assert not [part for part in every if part.get("items") is False], "kin-openapi, openapi-python-client, Redocly"
    for call, each in operations(description):
        content = each.get("requestBody", {}).get("content", {"application/json": {}})
        assert {"application/json", "application/octet-stream"} & set(content), call
    problem = description["components"]["schemas"]["Problem"]["properties"]
    assert {"detail", "code", "reason", "suggestions", "errors"} <= set(problem)
    assert "HTTPValidationError" not in description["components"]["schemas"]


def test_two_forms_of_one_name_are_refused() -> None:
    schemas = {"Ring": {"type": "object"}}
    add_schemas(schemas, {"Ring": {"type": "object"}})
    with pytest.raises(RuntimeError, match="Ring"):
        add_schemas(schemas, {"Ring": {"type": "string"}})


def test_every_call_can_be_copied_into_a_shell(description: Any) -> None:
    found = re.findall(r"```sh\n(curl .*)\n```", rest_page())
    assert len(found) == len(operations(description)) + 1
    for line in found:
        words = shlex.split(line)
        paths = (ADDRESS + "/api/", ADDRESS + "/metrics")
        assert words[0] == "curl" and any(word.startswith(paths) for word in words)
        if "-d" in words:
            assert isinstance(msgspec.json.decode(words[words.index("-d") + 1]), dict)


def test_the_reader_finds_the_address_by_which_he_came(live: Live) -> None:
    for host in (f"127.0.0.1:{live.port}", f"localhost:{live.port}"):
        page = live.ask("GET", "/docs", token=live.viewer, host=host).body.decode()
        assert f"http://{host}/api/commands" in page and ADDRESS not in page
        described = live.ask("GET", "/openapi.json", token=live.viewer, host=host).json
        assert described["servers"] == [{"url": f"http://{host}"}]
        assert described["components"]["securitySchemes"]["login"]["name"] == live.cookie_name


def test_the_description_is_printed_without_a_console(live: Live, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["openapi", "--server", "http://robot:1/"]) == 0
    printed = msgspec.json.decode(capsys.readouterr().out)
    served = live.ask("GET", "/openapi.json", token=live.viewer).json
    assert printed["servers"] == [{"url": "http://robot:1"}]
    assert all(printed[part] == served[part] for part in ("info", "paths"))
    assert printed["components"]["schemas"] == served["components"]["schemas"]


def test_the_messages_of_the_socket_keep_to_their_schema(live: Live) -> None:
    served = live.ask("GET", "/api/socket.json", token=live.viewer)
    assert served.status == 200 and served.json == socket_schema()
    down = jsonschema_rs.validator_for({**served.json, "anyOf": [{"$ref": "#/$defs/Down"}]})
    up = jsonschema_rs.validator_for({**served.json, "anyOf": [{"$ref": "#/$defs/Up"}]})
    with live.open() as line:
        for kind in ("hello", "state"):
            down.validate(hear(line, kind))
    assert not down.is_valid({"kind": "hello"}) and not up.is_valid({"kind": "stop", "press": -1})
    up.validate({"kind": "stop", "press": 7})
    named = {kind.__name__ for union, _ in UNIONS.values() for kind in get_args(union)}
    assert {kind.__name__ for kind in get_args(inbound.Up)} <= named <= set(served.json["$defs"])
