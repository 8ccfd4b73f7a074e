// Where views are taken: the big picture, what to show next, what became of it, and how far it has come.

import { make, mark, write } from "../element.js";
import { remember } from "../memory.js";
import { action, say } from "./action.js";
import { AdviceLine } from "./advice-line.js";
import * as api from "./api.js";
import { CameraChoice } from "./camera-choice.js";
import { takeDrops } from "./drops.js";
import { EmptyStage } from "./empty-stage.js";
import { eyeFor, isMirrored } from "./eye.js";
import { GainsCard } from "./gains-card.js";
import { KnownCard } from "./known-card.js";
import { PictureStage } from "./picture-stage.js";
import { ProgressCard } from "./progress-card.js";
import { RobotEye } from "./robot-eye.js";
import { Room } from "./room.js";
import { ScanView } from "./scan-view.js";
import { Uploads } from "./uploads.js";
import { UploadsCard } from "./uploads-card.js";
import { VerdictLine } from "./verdict-line.js";
import { ViewsCard } from "./views-card.js";
import { Webcam } from "./webcam.js";
import { quietWords } from "./words.js";

/** @typedef {import("./shape.js").Calibration} Calibration */

class CalibrationCapture extends Room {
  #stage = new PictureStage();
  #scan = new ScanView();
  #advice = new AdviceLine();
  #verdict = new VerdictLine();
  #empty = new EmptyStage();
  #showMe = action("assistant", "Show me");
  #live = action("pause", "Pause");
  #take = action("camera", "Take this picture");
  #mirror = action("mirror", "Mirror");
  #room = action("again", "Empty room anew");
  #choose = action("upload", "Choose pictures");
  #review = make("button", { type: "button", class: "button large to-review" });
  #cameras = new CameraChoice();
  #file = make("input", {
    type: "file",
    class: "visually-hidden",
    accept: "image/jpeg,image/png",
    multiple: true,
    tabindex: "-1",
    "aria-label": "Pictures of the board",
  });
  #progress = new ProgressCard();
  #known = new KnownCard();
  #gains = new GainsCard();
  #uploaded = new UploadsCard();
  #views = new ViewsCard();
  /** @type {import("./eye.js").Eye | null} */
  #eye = null;
  #eyeOf = "";
  #watched = ""; // the session that looks at the robot for us
  #showing = false;
  #paused = false;

  /** @override */
  build() {
    this.append(
      make(
        "div",
        { class: "capture" },
        make(
          "section",
          { class: "stage-box", "aria-label": "Picture" },
          make(
            "div",
            { class: "split" },
            make("div", { class: "picture-frame" }, this.#stage, this.#empty, this.#verdict),
            this.#scan,
          ),
          this.#advice,
          make(
            "div",
            { class: "stage-actions" },
            this.#showMe,
            this.#live,
            this.#take,
            this.#choose,
            this.#file,
            this.#mirror,
            this.#room,
            this.#cameras,
          ),
          this.#gains,
        ),
        make("div", { class: "wizard-side" }, this.#progress, this.#review, this.#known, this.#uploaded, this.#views),
      ),
    );
    this.#listen();
  }

  #listen() {
    const { bench } = this;
    /** @param {(id: string) => Promise<any>} act */
    const wish = (act) => void bench.wish(act);
    this.#advice.another = () => wish(api.another);
    this.#advice.amend = (counts) => void this.#amend(counts);
    this.#live.addEventListener("click", () => this.#pause());
    this.#take.addEventListener("click", () => void this.#takeOne());
    this.#room.addEventListener("click", () => wish(api.background));
    this.#showMe.addEventListener("click", () => wish((id) => api.showMe(id, !bench.calibration?.showing)));
    this.#review.addEventListener(
      "click",
      () => bench.calibration && bench.go({ at: "review", id: bench.calibration.id }),
    );
    this.#mirror.addEventListener("click", () => {
      remember(`mirror.${bench.calibration?.source}`, String(!this.#mirrored));
      this.draw();
    });
    this.#views.chosen = () => this.#review.click();
    this.#choose.addEventListener("click", () => this.#file.click());
    this.#file.addEventListener("change", () => {
      this.#add(this.#file.files ?? []);
      this.#file.value = "";
    });
    this.#empty.pressed = () => {
      if (this.#eye instanceof Uploads) this.#file.click();
      else if (this.#eye instanceof Webcam) void this.#openWebcam(this.#eye);
    };
    this.#cameras.changed = () => {
      if (this.#eye instanceof Webcam) void this.#openWebcam(this.#eye);
    };
    takeDrops(
      this,
      () => this.#eye instanceof Uploads,
      (files) => this.#add(files),
    );
    const beat = () => {
      requestAnimationFrame(beat);
      if (!this.hidden && this.#eye) this.#paint();
    };
    requestAnimationFrame(beat);
  }

  get #mirrored() {
    return isMirrored(this.bench.calibration?.source);
  }

  /** @override */
  left() {
    this.#eye?.close();
    this.#eye = null;
    this.#eyeOf = "";
    this.#rest();
  }

  /** Nobody looks any more: views are not taken behind our back, unless the assistant is at work. */
  #rest() {
    const id = this.#watched;
    this.#watched = "";
    if (id && !this.#showing && this.bench.may) api.live(id, false).catch(() => undefined);
  }

  /** @override */
  draw() {
    const { bench } = this;
    const { calibration } = bench;
    if (!calibration) return;
    this.#look(calibration);
    const { kind, source, live, showing, progress } = calibration;
    this.#showing = showing;
    mark(this, "data-kind", kind);
    mark(this, "data-source", source);
    this.#scan.hidden = this.#gains.hidden = kind === "camera";
    this.#known.hidden = kind === "laser";
    this.#uploaded.hidden = source !== "upload";
    this.#progress.show(calibration);
    if (kind === "camera") this.#known.show(calibration);
    else this.#gains.show(calibration);
    if (this.#eye instanceof Uploads) this.#uploaded.show(this.#eye);
    this.#views.show(bench, calibration);
    this.#advice.show(calibration, this.#mirrored, bench.may);

    const robot = source === "robot";
    this.#showMe.hidden = !bench.may || !robot || !bench.simulated;
    say(this.#showMe, showing ? "Let me do it" : "Show me", showing ? "hand" : "assistant");
    mark(this.#showMe, "data-inviting", !showing && !progress.ready);
    this.#live.hidden = !bench.may || source === "upload";
    const looking = robot ? live : !this.#paused;
    say(this.#live, looking ? "Pause" : "Go on", looking ? "pause" : "play");
    this.#take.hidden = !bench.may || source === "upload" || kind === "laser";
    this.#choose.hidden = !bench.may || source !== "upload";
    this.#room.hidden = !bench.may || kind !== "laser";
    this.#mirror.hidden = source === "upload";
    mark(this.#mirror, "aria-pressed", String(this.#mirrored));
    write(this.#review, progress.ready ? "Done: review and use" : "Review");
    mark(this.#review, "class", `button large to-review${progress.ready ? " primary" : ""}`);
  }

  /** What changes with every picture. */
  #paint() {
    const { calibration } = this.bench;
    if (!calibration || !this.#eye) return;
    const mirrored = this.#mirrored;
    const { frame, why } = this.#eye;
    this.#stage.show({ frame, calibration, verdict: calibration.verdict, mirrored });
    if (calibration.kind === "laser") this.#scan.show(calibration.scan);
    const offer = this.#eye instanceof Uploads ? "Choose pictures" : "Turn the camera on";
    const helps = this.#eye instanceof Uploads || (this.#eye instanceof Webcam && this.#eye.refused);
    this.#empty.show(frame && !(this.#eye instanceof Webcam) ? "" : why, this.bench.may && helps ? offer : "");
    if (this.#eye instanceof Webcam && why) {
      this.#verdict.hidden = true; // why there is no picture stands in its middle
      return;
    }
    this.#verdict.show(calibration, {
      mirrored,
      quiet: quietWords(calibration, {
        paused: calibration.source === "robot" ? !calibration.live : this.#paused,
        blind: this.#eye instanceof RobotEye && frame ? why : "",
        simulated: this.bench.simulated,
      }),
      say: (sentence) => this.session.announce(sentence),
      counted: () => this.#stage.flash(),
    });
  }

  #pause() {
    const { calibration } = this.bench;
    if (!calibration) return;
    if (calibration.source === "robot") void this.bench.wish((id) => api.live(id, !calibration.live));
    else {
      this.#paused = !this.#paused;
      if (this.#eye instanceof Webcam) this.#eye.paused = this.#paused;
      this.draw();
    }
  }

  /**
   * The board has other counts than were entered: the same session, begun anew with these.
   * @param {{columns: number, rows: number}} counts
   */
  async #amend(counts) {
    const { calibration } = this.bench;
    if (!calibration) return;
    const { kind, source, board, id, height_m = null } = calibration;
    const panel_m = board.panel_m ?? null;
    const wish = { kind, source, board: { ...board, ...counts, panel_m }, height_m };
    const eye = this.#eye;
    eye?.close();
    if (eye instanceof Webcam) await eye.idle();
    const begun = await this.bench.tried(() => api.begin(wish));
    if (!begun) {
      this.#eyeOf = ""; // look again
      return;
    }
    remember("board", JSON.stringify(wish.board));
    this.bench.go({ at: "capture", id: begun.id });
    await this.bench.tried(() => api.forget(id));
  }

  async #takeOne() {
    const { bench } = this;
    const eye = this.#eye;
    const verdict = await bench.wish(async (id) => {
      if (!(eye instanceof Webcam)) return api.capture(id);
      const picture = eye.snapshot();
      if (!picture) throw new Error(eye.why || "There is no picture yet.");
      const number = (bench.calibration?.views.length ?? 0) + 1;
      return api.send(id, picture, { name: `view ${number}` });
    });
    if (verdict) bench.judge(verdict);
  }

  /**
   * Opens the right source for this session.
   * @param {Calibration} calibration
   */
  #look({ id, source, live }) {
    const key = `${id} ${source}`;
    if (key === this.#eyeOf) return;
    this.#eye?.close();
    this.#eyeOf = key;
    this.#paused = false;
    const { bench } = this;
    const eye = eyeFor(source, id, bench, this.session);
    this.#eye = eye;
    if (eye instanceof Webcam) {
      if (bench.may) void this.#openWebcam(eye); // who only watches is not asked for a camera
    } else if (eye instanceof RobotEye) {
      eye.open();
      this.#watched = id;
      if (!live && bench.may) void bench.wish((session) => api.live(session, true));
    }
  }

  /** @param {Webcam} webcam */
  async #openWebcam(webcam) {
    await webcam.open(this.#cameras.chosen);
    await this.#cameras.show(webcam);
  }

  /** @param {Iterable<File>} files */
  #add(files) {
    if (this.#eye instanceof Uploads && this.bench.may) void this.#eye.add(files);
  }
}

customElements.define("calibration-capture", CalibrationCapture);
