"""The worker that connects to a robot to see what is there: a driver that hangs or breaks is killed with it."""

import http.client
import time
from urllib.parse import urlsplit

from console.workers.job import job
from core.errors import Unavailable
from core.pilot.replayed_drive import open_robot
from core.recording import LogSettings
from core.robots.connect import devices_of, live, parts_of
from core.robots.connection import FoundRobot, ReadConnection
from core.robots.robot_file import RobotFile, parse_robot_file, toml_text
from core.robots.usb_camera import VideoCamera
from core.settings import Settings

RATE_LISTENING_S = 2.0  # [s], over which the rates are measured
NAME = "The robot file"
CAMERA_ANSWER_S = 4.0  # [s] for a camera to say what it sends
PICTURE_TYPES = ("image/", "video/", "multipart/x-mixed-replace")
NO_PICTURES = "{host} sends no pictures ({kind}); a camera sends images, a video or multipart/x-mixed-replace."


class ProbeWorker:
    """Remembers nothing from job to job."""

    @job
    def probe(self, file: RobotFile, *, restrained: bool) -> FoundRobot:
        """Connect by the file's URL, listen for some seconds, let go; nothing is driven.

        `restrained`: a camera on the network sends pictures from the address that was named, or nothing. Raises
        BadInput, Unavailable.
        """
        if restrained:
            VideoCamera.restrained = True
            for part in parts_of(file.url):
                if part.startswith("camera://http/"):
                    check_sends_pictures(f"http://{part.removeprefix('camera://http/')}")
        robot = live(file.url, file)
        try:
            time.sleep(RATE_LISTENING_S)
            return robot.ask(ReadConnection())
        finally:
            robot.close()

    @job
    def check(self, file: RobotFile, comment: str) -> str:
        """Write a file's text, read it back, and ask its drivers about their entries → the text.

        Raises BadInput, Unavailable.
        """
        text = toml_text(file, comment)
        read = parse_robot_file(text, NAME)
        devices_of(read.url, read)
        return text

    @job
    def read(self, path: str, settings: LogSettings) -> None:
        """Read a recording, FILE or FILE#N, whole, as its replay does. Raises BadInput with the reader's sentence."""
        open_robot(path, seed=0, settings=Settings(log=settings)).close()


def check_sends_pictures(url: str) -> None:
    """Ask a camera what it sends, and follow it nowhere. Raises Unavailable."""
    parts = urlsplit(url)
    connection = http.client.HTTPConnection(parts.hostname or "", parts.port or 80, timeout=CAMERA_ANSWER_S)
    try:
        connection.request("GET", f"{parts.path or '/'}{'?' if parts.query else ''}{parts.query}")
        answer = connection.getresponse()
        kind = (answer.getheader("content-type") or "no type").partition(";")[0].strip().lower()
    except (OSError, http.client.HTTPException, ValueError) as trouble:
        raise Unavailable(f"{parts.netloc} does not answer as a camera: {trouble}.") from None
    finally:
        connection.close()
    if answer.status != 200 or not kind.startswith(PICTURE_TYPES):
        raise Unavailable(
            NO_PICTURES.format(host=parts.netloc.rpartition("@")[2], kind=f"{answer.status}, {kind}"[:60])
        )
