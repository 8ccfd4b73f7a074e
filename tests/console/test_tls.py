"""The console by HTTPS, so that a phone's browser gives it the microphone."""

import http.client
import shutil
import ssl
import subprocess
from pathlib import Path

import pytest
from websockets.sync.client import connect

from console.listening import announce
from console.options import Options, check
from core.errors import BadInput
from tests.console.live import Live

openssl = pytest.mark.skipif(
    shutil.which("openssl") is None, reason="a certificate needs openssl: apt install openssl"
)


def certificate(folder: Path, bearer: str = "IP:127.0.0.1") -> tuple[Path, Path]:
    """For this bearer, signed by itself."""
    made, key = folder / "cert.pem", folder / "key.pem"
    wish = [
        "-newkey",
        "rsa:2048",
        "-nodes",
        "-days",
        "2",
        "-subj",
        "/CN=beckon",
        "-addext",
        f"subjectAltName={bearer}",
    ]
    subprocess.run(
        ["openssl", "req", "-x509", *wish, "-keyout", str(key), "-out", str(made)], check=True, capture_output=True
    )
    return made, key


@openssl
def test_page_cookie_and_sockets_come_by_https(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made, key = certificate(tmp_path)
    options = Options(tls_cert=made, tls_key=key, open_browser=False)
    check(options)
    with Live(tmp_path / "home", tls=(made, key)) as live:
        trust = ssl.create_default_context(cafile=str(made))
        line = http.client.HTTPSConnection("127.0.0.1", live.port, context=trust, timeout=60)
        headers = {"Origin": f"https://127.0.0.1:{live.port}", "Content-Type": "application/json"}
        line.request("POST", "/api/login", f'{{"token": "{live.operator}"}}', headers)
        answer = line.getresponse()
        assert answer.status < 300 and "Secure" in (answer.getheader("set-cookie") or "")
        line.close()
        told = {"Authorization": f"Bearer {live.operator}"}
        address = f"wss://127.0.0.1:{live.port}/ws/audio"
        with connect(address, additional_headers=told, ssl=trust, proxy=None, compression=None) as socket:
            socket.send('{"kind": "rest"}')
            assert "listening" in str(socket.recv(timeout=10))
        announce(options, live.port, live.runtime.access)
    assert capsys.readouterr().out.startswith(f"Beckon is at https://127.0.0.1:{live.port}/#t=")


def test_what_is_no_certificate_is_told(tmp_path: Path) -> None:
    junk = tmp_path / "junk.pem"
    junk.write_text("hello")
    with pytest.raises(BadInput, match="belong together"):
        check(Options(tls_cert=junk))
    with pytest.raises(BadInput, match=r"nowhere\.pem is not there"):
        check(Options(tls_cert=tmp_path / "nowhere.pem", tls_key=junk))
    with pytest.raises(BadInput, match="no certificate in PEM"):
        check(Options(tls_cert=junk, tls_key=junk))
