"""Endpoints that answer with structs: what is sent, and what the description says of it."""

from typing import Any

import msgspec
import pytest
from fastapi import Response
from starlette.testclient import TestClient

from console.access.roles import needs
from console.api import router
from console.api.documentation import DescribedApp

shapes = router("shapes")


class Dot(msgspec.Struct, frozen=True):
    at_m: tuple[float, float]


class Ring(msgspec.Struct, frozen=True):
    middle: Dot
    radius_m: float
    name: str | msgspec.UnsetType = msgspec.UNSET
    raw: bytes = b"\x00\xff"


@shapes.get("/ring", status_code=201)
@needs("viewer")
async def ring(response: Response, radius_m: float = 2.0) -> Ring:
    """A struct, with a header of its own."""
    response.headers["Location"] = "rings/1"
    return Ring(Dot((1.0, 2.0)), radius_m)


@shapes.get("/either")
@needs("viewer")
async def either(dot: bool) -> Dot | Ring:
    return Dot((0.0, 0.0)) if dot else Ring(Dot((0.0, 0.0)), float("nan"))


@shapes.get("/plain")
@needs("viewer")
async def plain() -> dict[str, int]:
    """No struct."""
    return {"n": 1}


@pytest.fixture
def app() -> DescribedApp:
    app = DescribedApp(docs_url=None, redoc_url=None, openapi_url=None)
    app.router.routes.extend(shapes.routes)
    return app


def test_a_struct_is_sent_with_status_and_headers_and_without_what_is_unset(app: DescribedApp) -> None:
    answer = TestClient(app).get("/api/ring?radius_m=3.5")
    assert (answer.status_code, answer.headers["location"]) == (201, "rings/1")
    assert answer.json() == {"middle": {"at_m": [1.0, 2.0]}, "radius_m": 3.5, "raw": "AP8="}
    assert TestClient(app).get("/api/either?dot=false").json()["radius_m"] is None
    assert TestClient(app).get("/api/plain").json() == {"n": 1}


def test_the_description_names_the_structs(app: DescribedApp) -> None:
    description = app.openapi()

    def schema(path: str, status: str = "200") -> Any:
        return description["paths"][path]["get"]["responses"][status]["content"]["application/json"]["schema"]

    dot, circle = ({"$ref": f"#/components/schemas/{name}"} for name in ("Dot", "Ring"))
    assert schema("/api/ring", "201") == circle
    assert schema("/api/either") == {"anyOf": [dot, circle]}
    shown = description["components"]["schemas"]
    assert shown["Ring"]["required"] == ["middle", "radius_m"]
    pair = {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}
    assert shown["Dot"]["properties"]["at_m"] == pair
    assert "422" in description["paths"]["/api/ring"]["get"]["responses"]
