// Picture source: the camera of this device. Sends at most eight frames per second, one at a time:
// the next one waits for the verdict on the one before.

import { t } from "../ui/texts.js";

/** @import { Frame } from "./picture-source.js" */

const PERIOD_MS = 125;
const WIDEST = 1280; // [px] that a frame is sent at
const QUALITY = 0.9;

const REFUSALS = /** @type {Readonly<Record<string, string>>} */ ({
  NotAllowedError: t("webcam.the_browser_does_not_let_this") + t("webcam.then_press_the_button"),
  NotFoundError: t("webcam.this_device_has_no_camera_that"),
  NotReadableError: t("webcam.another_program_is_using_the_camera"),
  OverconstrainedError: t("webcam.that_camera_is_no_longer_available"),
  AbortError: t("webcam.the_camera_stopped_while_it_was"),
});

/** @returns {string} why this page may not use a camera; "" when it may ask */
export function webcamRefusal() {
  if (globalThis.isSecureContext && navigator.mediaDevices) return "";
  return t("webcam.only_secure") + t("webcam.open_beckon_that_way_or_use");
}

export class Webcam {
  /** @type {MediaStream | null} */
  #stream = null;
  #video = document.createElement("video");
  #canvas = document.createElement("canvas");
  #why = "";
  #timer = 0;
  /** @type {Promise<unknown> | null} the frame that is on its way */
  #sent = null;
  #paused = false;
  #turn = 0;

  /** @param {(frame: Blob, stamp_s: number) => Promise<unknown>} send resolves when the console has judged the frame */
  constructor(send) {
    this.send = send;
    this.#video.muted = true;
    this.#video.playsInline = true;
  }

  /** @returns {string} why there is no picture; "" when there is one */
  get why() {
    return this.frame ? "" : this.#why || t("webcam.the_camera_is_starting");
  }

  /** True when pressing the button may help. */
  get refused() {
    return this.#why !== "" && webcamRefusal() === "";
  }

  /** @returns {Frame | null} */
  get frame() {
    const { videoWidth: width, videoHeight: height } = this.#video;
    if (!this.#stream || !width) return null;
    return { image: this.#video, width, height, key: `webcam ${this.#turn}`, stamp_s: null };
  }

  set paused(/** @type {boolean} */ paused) {
    this.#paused = paused;
  }

  /** @param {string} [device] id, where there are several cameras */
  async open(device) {
    this.close();
    const turn = this.#turn;
    this.#why = webcamRefusal();
    if (this.#why) return;
    try {
      const size = { width: { ideal: WIDEST }, height: { ideal: 720 } };
      const which = device ? { deviceId: { exact: device } } : { facingMode: "user" };
      const stream = await navigator.mediaDevices.getUserMedia({ video: { ...size, ...which }, audio: false });
      if (turn !== this.#turn) {
        for (const track of stream.getTracks()) track.stop();
        return;
      }
      this.#stream = stream;
      stream.getVideoTracks()[0]?.addEventListener("ended", () => {
        this.close();
        this.#why = t("webcam.the_camera_was_unplugged_or_switched");
      });
      this.#video.srcObject = stream;
      await this.#video.play();
      this.#timer = window.setInterval(() => void this.#beat(), PERIOD_MS);
    } catch (error) {
      this.close();
      const name = error instanceof DOMException ? error.name : "";
      this.#why = REFUSALS[name] ?? t("webcam.the_camera_could_not_be_started");
    }
  }

  close() {
    this.#turn += 1;
    clearInterval(this.#timer);
    for (const track of this.#stream?.getTracks() ?? []) track.stop();
    this.#stream = null;
    this.#video.srcObject = null;
    this.#why = "";
  }

  /** @returns {Promise<Array<{id: string, name: string}>>} the cameras of this device, once one of them was allowed */
  async choices() {
    if (webcamRefusal()) return [];
    const devices = await navigator.mediaDevices.enumerateDevices();
    return devices
      .filter((device) => device.kind === "videoinput" && device.deviceId)
      .map((device, index) => ({
        id: device.deviceId,
        name: device.label || t("webcam.camera_index", { index: index + 1 }),
      }));
  }

  /** @returns {Blob | null} the present picture as a JPEG */
  snapshot() {
    const frame = this.frame;
    const brush = this.#canvas.getContext("2d", { willReadFrequently: true });
    if (!frame || !brush) return null;
    const scale = Math.min(1, WIDEST / frame.width);
    const [width, height] = [Math.round(frame.width * scale), Math.round(frame.height * scale)];
    if (this.#canvas.width !== width || this.#canvas.height !== height)
      [this.#canvas.width, this.#canvas.height] = [width, height];
    brush.drawImage(frame.image, 0, 0, width, height);
    // toBlob waits for an idle moment; a busy page has one per second
    const [, coded = ""] = this.#canvas.toDataURL("image/jpeg", QUALITY).split(",");
    const bytes = Uint8Array.from(atob(coded), (letter) => letter.charCodeAt(0));
    return new Blob([bytes], { type: "image/jpeg" });
  }

  /** Resolve when no frame is being sent. */
  async idle() {
    await this.#sent;
  }

  async #beat() {
    if (this.#sent || this.#paused || document.visibilityState === "hidden") return;
    const picture = this.snapshot();
    if (!picture) return;
    const stamp_s = (performance.timeOrigin + performance.now()) / 1e3;
    this.#sent = this.send(picture, stamp_s).catch(() => null); // the next frame follows; the page shows the trouble
    await this.#sent;
    this.#sent = null;
  }
}
