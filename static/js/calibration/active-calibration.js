// Sentences about the active calibration of the camera and of the laser mount.

import { age, date, fixed } from "../ui/format.js";
import { inLanguage, t } from "../ui/texts.js";

/** @import { Kind } from "./types.js" */

const SAVING_S = 30; // that saving a calibration may take

/** @param {Kind} kind @param {Record<string, any>} report */
export function inWords(kind, report) {
  if (report["not_used"]) return inLanguage(report["not_used"]);
  const when = typeof report["accepted_s"] === "number" ? `, ${since(report["accepted_s"])}` : "";
  if (kind === "laser")
    return t("active-calibration.in_use_reportwhen", {
      report: report["laser_offset_words"] ?? t("active-calibration.a_calibrated_mount"),
      when,
    });
  const p95 = report["uncertainty"]?.p95_px ?? report["p95_uncertainty_px"];
  const sure =
    typeof p95 === "number" ? t("active-calibration.95_of_the_picture_known_to", { fixed: fixed(p95, 2) }) : "";
  const focal =
    typeof report["fx"] === "number"
      ? t("active-calibration.focal_length_fixed_px", { fixed: fixed(report["fx"], 1) })
      : t("active-calibration.a_calibrated_camera");
  return t("active-calibration.in_use_focalsurewhen", { focal, sure, when });
}

/** What taking it back brings into use, as a button says it. @param {Record<string, any> | null | undefined} report */
export const takesBack = (report) =>
  t(
    report?.["former"] === false
      ? "active-calibration.use_the_nominal_values"
      : "active-calibration.take_the_former_one_back",
  );

/** @param {Record<string, any> | null} former the calibration that is in use now */
export const takenBack = (former) =>
  t("active-calibration.taken_back_value_to_undo_this", {
    value: former
      ? t("active-calibration.the_former_one_is_in_use")
      : t("active-calibration.the_nominal_values_are_used_now"),
  });

/**
 * What became of a session, in words.
 * @param {import("../net/rest.js").SessionRow} row
 * @param {Record<string, any> | null | undefined} used the calibration of its kind that is in use; undefined: not known
 */
export function standing({ accepted, accepted_s, ready }, used) {
  if (!accepted)
    return ready ? t("active-calibration.good_enough_not_yet_accepted") : t("active-calibration.not_finished");
  if (used === undefined || accepted_s === null) return "accepted";
  const later = used === null ? Infinity : accepted_s - used["accepted_s"]; // a session is marked right after it is used
  return later > -1 && later < SAVING_S
    ? t(used?.["not_used"] ? "active-calibration.accepted_not_used" : "active-calibration.in_use")
    : t("active-calibration.was_in_use_accepted_since", { since: since(accepted_s) });
}

/** @param {number} at Unix time [s] */
export function since(at) {
  const seconds = Date.now() / 1000 - at;
  return seconds < 60
    ? t("active-calibration.just_now")
    : seconds < 86400
      ? t("active-calibration.age_ago", { age: age(seconds) })
      : date(at);
}
