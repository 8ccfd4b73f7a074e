"""Endpoints that answer with a struct: encoded by msgspec, and described in OpenAPI by the struct itself."""

import functools
import inspect
from collections.abc import Callable, Coroutine, Iterable
from types import UnionType
from typing import Any, TypeVar, Union, cast, get_args, get_origin

import msgspec
from fastapi import Response
from fastapi.responses import JSONResponse
from fastapi.routing import APIRoute

from core.sentences import plain

OpenApi = dict[str, Any]  # a part of an OpenAPI description
Responses = dict[int | str, OpenApi]  # by status
Endpoint = Callable[..., Coroutine[Any, Any, Any]]

REF = "#/components/schemas/{name}"
DECLARED = "beckon_answer"  # the attribute of an endpoint that encodes its answer itself

EndpointT = TypeVar("EndpointT", bound=Endpoint)


def sends(kind: Any) -> Callable[[EndpointT], EndpointT]:
    """Declare the struct, or the union of structs, that an endpoint sends as JSON of its own making."""

    def declare(endpoint: EndpointT) -> EndpointT:
        setattr(endpoint, DECLARED, kind)
        return endpoint

    return declare


class JsonAnswer(JSONResponse):
    """JSON as msgspec writes it."""

    def render(self, content: Any) -> bytes:
        """Plain values → JSON."""
        return msgspec.json.encode(content, enc_hook=plain)


class TypedRoute(APIRoute):
    """A route whose endpoint may say that it returns a struct, or one of several; all else is as in any route."""

    def __init__(self, path: str, endpoint: Endpoint, **options: Any) -> None:
        words = " ".join((inspect.getdoc(endpoint) or endpoint.__name__).split())
        options["summary"] = options.get("summary") or words.partition(". ")[0].removesuffix(".")
        signature = inspect.signature(endpoint, eval_str=True)
        own = getattr(endpoint, DECLARED, None)
        structs = structs_of(signature.return_annotation if own is None else own)
        self.structs = structs  # that the description of the answer names; `schemas_of` has their form
        if structs:
            schemas: list[OpenApi] = [{"$ref": REF.format(name=kind.__name__)} for kind in structs]
            schema = schemas[0] if len(schemas) == 1 else {"anyOf": schemas}
            status: int = options.get("status_code") or 200
            described: Responses = {status: {"content": {"application/json": {"schema": schema}}}}
            options |= {"responses": described | (options.get("responses") or {}), "response_model": None}
            if own is None:
                options["response_class"] = JsonAnswer
                endpoint = in_json(endpoint, signature, status)
        super().__init__(path, endpoint, **options)


def structs_of(hint: Any) -> tuple[type[msgspec.Struct], ...]:
    """Return the structs of a return annotation: it is one, or a union of them; none for anything else."""
    kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    are_structs = all(isinstance(kind, type) and issubclass(kind, msgspec.Struct) for kind in kinds)
    return kinds if are_structs else ()


def schemas_of(structs: Iterable[type[msgspec.Struct]]) -> OpenApi:
    """Return the schemas of structs and of all that they hold, by name: of many at once, which takes far less time.

    Raises RuntimeError for two of one name.
    """
    _, schemas = msgspec.json.schema_components(structs, ref_template=REF)
    for name in schemas:
        if "." in name:  # msgspec tells them apart by their modules
            raise RuntimeError(f"Two structs of the interface are called {name.rpartition('.')[2]}; rename one.")
    return with_plain_tuples(schemas)


def with_plain_tuples(schema: Any) -> Any:
    """Describe tuples as every tool reads them: alike ones without `prefixItems`, others without `items: false`."""
    if isinstance(schema, list):
        return [with_plain_tuples(part) for part in cast(list[Any], schema)]
    if not isinstance(schema, dict):
        return schema
    plain: OpenApi = {name: with_plain_tuples(part) for name, part in cast(OpenApi, schema).items()}
    first, *others = plain.get("prefixItems") or [None]
    if first is not None and all(other == first for other in others):
        del plain["prefixItems"]
        plain["items"] = first
    elif plain.get("items") is False:  # minItems and maxItems say it already, and generators want a schema
        del plain["items"]
    return plain


def in_json(endpoint: Endpoint, signature: inspect.Signature, status: int) -> Endpoint:
    """Return the same endpoint with its struct as JSON; in plain values where it sets headers of its own."""
    sets_headers = any(one.annotation is Response for one in signature.parameters.values())

    @functools.wraps(endpoint)
    async def answer(**given: Any) -> Any:
        found = await endpoint(**given)
        return msgspec.to_builtins(found, enc_hook=plain) if sets_headers else JsonAnswer(found, status)

    answer.__signature__ = signature.replace(return_annotation=Any)  # type: ignore[attr-defined]
    return answer
