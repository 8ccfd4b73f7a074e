"""The fleet's own small authority: a certificate for its router, one for each robot, one for each viewer.

`openssl` makes them; what was made is listed in `certificates.json`, from which the router knows whom to let in.
"""

import contextlib
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import msgspec

from core.errors import BadInput, Unavailable
from core.files import locked, saving, write_atomic
from core.sentences import Statement

CERTIFICATE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")
ROUTER_NAME = "fleet"  # common name of the router's certificate
AUTHORITY_DAYS, CERTIFICATE_DAYS = 3650, 825
MIN_DAYS_LEFT = 30  # of the router's certificate, below which a new one is made at a start
MAX_ROBOTS = 100
OPENSSL_TIMEOUT_S = 20.0
DAY_S = 24 * 3600.0
ISSUED_FILE, LOCK_FILE = "certificates.json", "certificates.lock"

CertificateKind = Literal["robot", "viewer"]


class FleetCertificate(msgspec.Struct, frozen=True):
    """A certificate that was made, without its key."""

    name: str
    kind: CertificateKind
    made_s: float  # Unix time
    end_s: float  # Unix time
    number: int = 0  # no other of this name has it; 0: of an earlier version

    @property
    def common_name(self) -> str:
        """The name that the certificate bears: by it, only the newest one of a name is let in."""
        return f"{self.name}.{self.number}" if self.number else self.name


@dataclass(frozen=True)
class CertificateFiles:
    """The proof of one side of a connection, and its means to check the other side: PEM files in one folder."""

    folder: Path

    @property
    def authority(self) -> Path:
        return self.folder / "authority.pem"

    @property
    def certificate(self) -> Path:
        return self.folder / "certificate.pem"

    @property
    def key(self) -> Path:
        return self.folder / "key.pem"

    def check(self) -> None:
        """Raises BadInput where one is missing."""
        missing = [path for path in (self.authority, self.certificate, self.key) if not path.is_file()]
        if missing:
            raise BadInput(Statement("fleet.no_certificate", path=missing[0]))


class Authority:
    """The authority of one fleet, in a folder that is its owner's alone."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._own = CertificateFiles(folder / "authority")
        self.router = CertificateFiles(folder / "router")

    def prepare(self, hosts: tuple[str, ...]) -> None:
        """Have an authority, and a certificate of the router for these names and addresses. Raises Unavailable."""
        with self._alone():
            self._prepare_authority()
        noted = self.router.folder / "hosts"
        wanted = " ".join(sorted({"localhost", "127.0.0.1", *hosts}))
        made_for = noted.read_text() if noted.is_file() else ""
        if made_for == wanted and self._signed_router() and _lasts(self.router.certificate, MIN_DAYS_LEFT):
            return
        names = ",".join(f"{'IP' if _is_address(host) else 'DNS'}:{host}" for host in wanted.split())
        self._sign(ROUTER_NAME, names, self.router, CERTIFICATE_DAYS)
        write_atomic(noted, wanted.encode())

    def issue(self, name: str, out: Path, *, kind: CertificateKind, days: int = CERTIFICATE_DAYS) -> FleetCertificate:
        """Make a certificate into the folder `out`. Raises BadInput, Unavailable, Unwritable."""
        if CERTIFICATE_NAME.fullmatch(name) is None or name == ROUTER_NAME:
            raise BadInput(Statement("fleet.name_refused", name=name[:60]))
        with self._alone():
            others = [one for one in self.certificates() if one.name != name]
            if sum(one.kind == "robot" for one in others) >= MAX_ROBOTS and kind == "robot":
                raise BadInput(Statement("fleet.full", most=MAX_ROBOTS))
            self._prepare_authority()
            if any(out.resolve() == own.folder.resolve() for own in (self._own, self.router)):
                raise BadInput(Statement("fleet.own_folder", path=out))
            now = time.time()
            made = FleetCertificate(name, kind, now, now + days * DAY_S, round(1000 * now))
            self._sign(made.common_name, f"DNS:{name}", CertificateFiles(out), days)
            self._list([*others, made])
        return made

    def withdraw(self, name: str) -> None:
        """Let the certificate of this name in no more. Raises BadInput where there is none."""
        with self._alone():
            listed = self.certificates()
            if all(one.name != name for one in listed):
                raise BadInput(Statement("fleet.unknown_name", name=name[:60]))
            self._list([one for one in listed if one.name != name])

    def certificates(self) -> list[FleetCertificate]:
        """All that are let in, in the order in which they were made. Raises BadInput for a damaged list."""
        path = self.folder / ISSUED_FILE
        try:
            return msgspec.json.decode(path.read_bytes(), type=list[FleetCertificate])
        except FileNotFoundError:
            return []
        except (OSError, msgspec.MsgspecError):
            raise BadInput(Statement("fleet.list_damaged", path=path)) from None

    @property
    def changed(self) -> float:
        """When the list was changed last, Unix time; 0: never."""
        try:
            return (self.folder / ISSUED_FILE).stat().st_mtime
        except FileNotFoundError:
            return 0.0

    def _signed_router(self) -> bool:
        """Return whether the router's certificate is of this authority, not of one that was here before."""
        there = self.router.authority
        return there.is_file() and there.read_bytes() == self._own.certificate.read_bytes()

    @contextlib.contextmanager
    def _alone(self) -> Generator[None]:
        """Read the list and write it again while nobody else does. Raises Unwritable."""
        with contextlib.ExitStack() as held:
            with saving("The certificate could not be listed"):
                self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
                held.enter_context(locked(self.folder / LOCK_FILE))
            yield

    def _list(self, listed: list[FleetCertificate]) -> None:
        with saving("The certificate could not be listed"):
            write_atomic(self.folder / ISSUED_FILE, msgspec.json.format(msgspec.json.encode(listed)) + b"\n")

    def _prepare_authority(self) -> None:
        own = self._own
        if own.certificate.is_file() and own.key.is_file():
            return
        with saving("The authority could not be made"):
            for folder in (self.folder, own.folder):
                folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            _make_key(own.key)
            made = own.folder / ".new.pem"
            subject = ("-subj", "/CN=Beckon fleet authority", "-days", str(AUTHORITY_DAYS))
            _openssl("req", "-x509", "-new", "-key", str(own.key), "-sha256", *subject, "-out", str(made))
            made.replace(own.certificate)

    def _sign(self, name: str, alternatives: str, files: CertificateFiles, days: int) -> None:
        with saving("The certificate could not be made"), tempfile.TemporaryDirectory() as folder:
            request, more, made, key = (Path(folder) / each for each in ("request", "more", "made", "key"))
            _make_key(key)
            _openssl("req", "-new", "-key", str(key), "-subj", f"/CN={name}", "-out", str(request))
            uses = "extendedKeyUsage=serverAuth,clientAuth\nbasicConstraints=critical,CA:FALSE\n"
            write_atomic(more, f"subjectAltName={alternatives}\n{uses}".encode())
            signer = ("-CA", str(self._own.certificate), "-CAkey", str(self._own.key), "-CAcreateserial")
            span = ("-days", str(days), "-sha256", "-extfile", str(more))
            _openssl("x509", "-req", "-in", str(request), *signer, *span, "-out", str(made))
            files.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            for source, target in (
                (key, files.key),
                (made, files.certificate),
                (self._own.certificate, files.authority),
            ):
                write_atomic(target, source.read_bytes(), 0o600)


def _make_key(path: Path) -> None:
    path.unlink(missing_ok=True)
    path.touch(0o600, exist_ok=False)
    _openssl("genpkey", "-algorithm", "EC", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-out", str(path))


def _lasts(certificate: Path, days: float) -> bool:
    if not certificate.is_file():
        return False
    check = ("x509", "-checkend", str(round(days * DAY_S)), "-noout", "-in", str(certificate))
    return _run(*check).returncode == 0


def _is_address(host: str) -> bool:
    return re.fullmatch(r"[0-9.]+|[0-9a-fA-F:]*:[0-9a-fA-F:]*", host) is not None


def _program() -> str:
    found = shutil.which("openssl")
    if found is None:
        raise Unavailable(Statement("fleet.no_openssl"))
    return found


def _run(*arguments: str) -> subprocess.CompletedProcess[bytes]:
    """Run openssl to its end. Raises Unavailable."""
    try:
        return subprocess.run([_program(), *arguments], capture_output=True, timeout=OPENSSL_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        raise Unavailable(Statement("fleet.openssl_failed", why="it did not end")) from None


def _openssl(*arguments: str) -> None:
    """Run openssl. Raises Unavailable with its own words."""
    done = _run(*arguments)
    if done.returncode:
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        raise Unavailable(Statement("fleet.openssl_failed", why=lines[-1] if lines else "no words"))
