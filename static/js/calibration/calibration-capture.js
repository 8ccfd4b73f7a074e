// Capture step of the camera and laser wizards: picture, advice, verdict and progress.

import { action, make, mark, say, write } from "../ui/element.js";
import { takeDrops } from "../ui/file-drop.js";
import { remember } from "../ui/local-storage.js";
import { t } from "../ui/texts.js";
import * as api from "./api.js";
import { CameraChoice, EmptyStage, GainsCard, KnownCard, ProgressCard, UploadsCard } from "./capture-cards.js";
import { CornerMarker } from "./corner-marker.js";
import { isMirrored, pictureSource, RobotCamera } from "./picture-source.js";
import { PictureStage } from "./picture-stage.js";
import { ScanView } from "./scan-view.js";
import { Uploads } from "./uploads.js";
import { AdviceLine, VerdictLine } from "./verdict-line.js";
import { ViewsCard } from "./views-card.js";
import { Webcam } from "./webcam.js";
import { WizardStep } from "./wizard-step.js";
import { quietWords } from "./words.js";

/** @import { Calibration } from "./types.js" */

class CalibrationCapture extends WizardStep {
  #stage = new PictureStage();
  #scan = new ScanView();
  #advice = new AdviceLine();
  #verdict = new VerdictLine();
  #empty = new EmptyStage();
  #showDemo = action("demo", t("calibration-capture.show_me"));
  #live = action("pause", t("calibration-capture.pause"), () => this.#pause());
  #take = action("camera", t("calibration-capture.take_this_picture"), () => void this.#takeOne());
  #mark = action(
    "pencil",
    t("calibration-capture.mark_the_corners"),
    () => this.#source?.frame && this.#marker.begin(this.#source.frame),
  );
  #marker = new CornerMarker();
  #mirror = action("mirror", t("calibration-capture.mirror"));
  #room = action(
    "again",
    t("calibration-capture.retake_the_empty_room"),
    () => void this.model.request(api.background),
  );
  #choose = action("upload", t("calibration-capture.choose_pictures"), () => this.#file.click());
  #review = make("button.button.large.to-review");
  #cameras = new CameraChoice();
  #file = make("input.visually-hidden", {
    type: "file",
    accept: "image/jpeg,image/png",
    multiple: true,
    tabindex: "-1",
    "aria-label": t("calibration-capture.pictures_of_the_board"),
  });
  #progress = new ProgressCard();
  #known = new KnownCard();
  #precision = new GainsCard();
  #uploaded = new UploadsCard();
  #views = new ViewsCard();
  /** @type {import("./picture-source.js").PictureSource | null} */
  #source = null;
  #sourceOf = "";
  #watched = ""; // the session whose live capture this page switched on
  /** @type {{id: string, files: File[]}} files that were judged for another board, to be judged in this session */
  #again = { id: "", files: [] };
  #demo = false;
  #paused = false;

  /** @override */
  build() {
    this.append(
      make(
        "div.capture",
        make(
          "section.stage-box",
          { "aria-label": t("calibration-capture.picture") },
          make(
            "div.split",
            make("div.picture-frame", this.#stage, this.#empty, this.#verdict, this.#marker),
            this.#scan,
          ),
          this.#advice,
          make(
            "div.row.stage-actions",
            this.#showDemo,
            this.#live,
            this.#take,
            this.#choose,
            this.#file,
            this.#mark,
            this.#mirror,
            this.#room,
            this.#cameras,
          ),
          this.#precision,
        ),
        make("div.wizard-side", this.#progress, this.#review, this.#known, this.#uploaded, this.#views),
      ),
    );
    this.#listen();
  }

  #listen() {
    const { model } = this;
    /** @param {(id: string) => Promise<any>} act */
    const request = (act) => void model.request(act);
    this.#advice.skip = () => request(api.skip);
    this.#advice.amend = (counts) => void this.#amend(counts);
    this.#showDemo.addEventListener("click", () => request((id) => api.showDemo(id, !model.calibration?.demo)));
    this.#review.addEventListener(
      "click",
      () => model.calibration && model.go({ at: "review", id: model.calibration.id }),
    );
    this.#marker.marked = (picture, corners) => void this.#sendMarked(picture, corners);
    this.#mirror.addEventListener("click", () => {
      remember(`mirror.${model.calibration?.source}`, String(!this.#mirrored));
      this.draw();
    });
    this.#views.chosen = () => this.#review.click();
    this.#file.addEventListener("change", () => {
      this.#add(this.#file.files ?? []);
      this.#file.value = "";
    });
    this.#empty.pressed = () => {
      if (this.#source instanceof Uploads) this.#file.click();
      else if (this.#source instanceof Webcam) void this.#openWebcam(this.#source);
    };
    this.#cameras.changed = () => {
      if (this.#source instanceof Webcam) void this.#openWebcam(this.#source);
    };
    takeDrops(
      this,
      () => this.#source instanceof Uploads,
      (files) => this.#add(files),
    );
    const beat = () => {
      requestAnimationFrame(beat);
      if (!this.hidden && this.#source) this.#paint();
    };
    requestAnimationFrame(beat);
  }

  get #mirrored() {
    return isMirrored(this.model.calibration?.source);
  }

  /** @override */
  left() {
    this.#source?.close();
    this.#source = null;
    this.#sourceOf = "";
    this.#marker.hidden = true;
    const id = this.#watched;
    this.#watched = "";
    if (id && !this.#demo && this.model.may) api.live(id, false).catch(() => undefined);
  }

  /** @override */
  draw() {
    const { model } = this;
    const { calibration } = model;
    if (!calibration) return;
    this.#look(calibration);
    const { kind, source, live, demo, progress } = calibration;
    this.#demo = demo;
    mark(this, "data-kind", kind);
    mark(this, "data-source", source);
    this.#scan.hidden = this.#precision.hidden = kind === "camera";
    this.#known.hidden = kind === "laser";
    this.#uploaded.hidden = source !== "upload";
    this.#progress.show(calibration);
    if (kind === "camera") this.#known.show(calibration);
    else this.#precision.show(calibration);
    if (this.#source instanceof Uploads) this.#uploaded.show(this.#source);
    this.#views.show(model, calibration);
    this.#advice.show(calibration, this.#mirrored, model.may);

    const robot = source === "robot";
    this.#showDemo.hidden = !model.may || !robot || !model.simulated;
    say(
      this.#showDemo,
      demo ? t("calibration-capture.stop_the_demo") : t("calibration-capture.show_me"),
      demo ? "hand" : "demo",
    );
    mark(this.#showDemo, "data-inviting", !demo && !progress.ready);
    this.#live.hidden = !model.may || source === "upload";
    const looking = robot ? live : !this.#paused;
    say(
      this.#live,
      looking ? t("calibration-capture.pause") : t("calibration-capture.go_on"),
      looking ? "pause" : "play",
    );
    this.#take.hidden = !model.may || source === "upload" || kind === "laser";
    this.#mark.hidden = !model.may || kind === "laser";
    this.#review.disabled = calibration.views.length === 0;
    this.#choose.hidden = !model.may || source !== "upload";
    this.#room.hidden = !model.may || kind !== "laser";
    this.#mirror.hidden = source === "upload";
    mark(this.#mirror, "aria-pressed", String(this.#mirrored));
    write(
      this.#review,
      progress.ready ? t("calibration-capture.done_review_and_use") : t("calibration-capture.review"),
    );
    mark(this.#review, "class", `button large to-review${progress.ready ? " primary" : ""}`);
  }

  /** Update everything that changes with each picture. */
  #paint() {
    const { calibration } = this.model;
    if (!calibration || !this.#source) return;
    this.#mark.disabled = this.#source.frame === null;
    const mirrored = this.#mirrored;
    const { frame, why } = this.#source;
    this.#stage.show({ frame, calibration, verdict: calibration.verdict, mirrored });
    if (calibration.kind === "laser") this.#scan.show(calibration.scan);
    const offer =
      this.#source instanceof Uploads
        ? t("calibration-capture.choose_pictures")
        : t("calibration-capture.turn_the_camera_on");
    const helps = this.#source instanceof Uploads || (this.#source instanceof Webcam && this.#source.refused);
    this.#empty.show(frame && !(this.#source instanceof Webcam) ? "" : why, this.model.may && helps ? offer : "");
    if (this.#source instanceof Webcam && why) {
      this.#verdict.hidden = true; // the empty stage shows the reason
      return;
    }
    this.#verdict.show(calibration, {
      mirrored,
      quiet: quietWords(calibration, {
        paused: calibration.source === "robot" ? !calibration.live : this.#paused,
        blind: this.#source instanceof RobotCamera && frame ? why : "",
        simulated: this.model.simulated,
      }),
      say: (sentence) => this.session.announce(sentence),
      counted: () => this.#stage.flash(),
    });
  }

  #pause() {
    const { calibration } = this.model;
    if (!calibration) return;
    if (calibration.source === "robot") void this.model.request((id) => api.live(id, !calibration.live));
    else {
      this.#paused = !this.#paused;
      if (this.#source instanceof Webcam) this.#source.paused = this.#paused;
      this.draw();
    }
  }

  /** Restart the session with the counts of the board that was seen. @param {{columns: number, rows: number}} counts */
  async #amend(counts) {
    const { calibration } = this.model;
    if (!calibration) return;
    const { kind, source, board, id, views, height_m = null } = calibration;
    const panel_m = board.panel_m ?? null;
    const request = { kind, source, board: { ...board, ...counts, panel_m }, height_m };
    const active = this.#source;
    active?.close();
    if (active instanceof Webcam || active instanceof Uploads) await active.idle();
    const begun = await this.model.tried(() => api.begin(request));
    if (!begun) {
      this.#sourceOf = ""; // look again
      return;
    }
    remember("board", JSON.stringify(request.board));
    this.#again = { id: begun.id, files: active instanceof Uploads ? active.files : [] };
    this.model.go({ at: "capture", id: begun.id });
    if (!views.length) await this.model.tried(() => api.forget(id)); // what was counted stays in the list
  }

  async #takeOne() {
    const { model } = this;
    const active = this.#source;
    const verdict = await model.request(async (id) => {
      if (!(active instanceof Webcam)) return api.capture(id);
      const picture = active.snapshot();
      if (!picture) throw new Error(active.why || "There is no picture yet.");
      const number = (model.calibration?.views.length ?? 0) + 1;
      return api.send(id, picture, { name: t("calibration-capture.view_number", { number }) });
    });
    if (verdict) model.judge(verdict);
  }

  /** @param {Blob} picture @param {import("./types.js").Pixel[]} corners */
  async #sendMarked(picture, corners) {
    const { model } = this;
    const number = (model.calibration?.views.length ?? 0) + 1;
    const name = t("calibration-capture.view_number", { number });
    const verdict = await model.request((id) => api.send(id, picture, { name, corners }));
    if (verdict) model.judge(verdict);
  }

  /** Open the picture source of this session. @param {Calibration} calibration */
  #look({ id, source, live }) {
    const key = `${id} ${source}`;
    if (key === this.#sourceOf) return;
    this.#source?.close();
    this.#sourceOf = key;
    this.#paused = false;
    const { model } = this;
    const active = pictureSource(source, id, model, this.session);
    this.#source = active;
    if (active instanceof Uploads && this.#again.id === id) this.#add(this.#again.files);
    else if (active instanceof Webcam) {
      if (model.may) void this.#openWebcam(active); // a viewer is not asked for a camera
    } else if (active instanceof RobotCamera) {
      active.open();
      this.#watched = id;
      if (!live && model.may) void model.request((session) => api.live(session, true));
    }
  }

  /** @param {Webcam} webcam */
  async #openWebcam(webcam) {
    await webcam.open(this.#cameras.chosen);
    await this.#cameras.show(webcam);
  }

  /** @param {Iterable<File>} files */
  #add(files) {
    if (this.#source instanceof Uploads && this.model.may) void this.#source.add(files);
  }
}

customElements.define("calibration-capture", CalibrationCapture);
