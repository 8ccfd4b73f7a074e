"""The sixty rows of the campaign: fault, goal, and the checks that hold it."""

from dataclasses import dataclass

from tests.campaign import measurements as measure
from tests.campaign.figures import Measurement


@dataclass(frozen=True)
class CampaignRow:
    """A fault or an attack, and what is required of Beckon then."""

    row: str
    fault: str
    goal: str
    tests: tuple[str, ...] = ()  # `file::test` below tests/
    measurements: tuple[Measurement, ...] = ()
    size: str = "minutes"  # the smallest class in which the measurements are made; tests belong to `seconds`
    missing: str = ""  # why a part of it, or all of it, is not checked, and what protects instead
    instead: str = ""  # what protects where it fails

    @property
    def number(self) -> int:
        return int(self.row[1:])


def _in(file: str, *names: str) -> tuple[str, ...]:
    return tuple(f"{file}::test_{name}" for name in names)


GATE, PROCESS = "core/gate/test_gate.py", "core/gate/test_gate_process.py"
SUPERVISOR, GUARD = "console/robot/test_supervisor.py", "console/access/test_access_guard.py"
ORDERS, SOCKET = "console/test_orders.py", "console/api/test_state_socket.py"
FOLDER, SERVE = "console/test_data_folder.py", "console/test_serve.py"
HANDS, LIVE = "browser/test_page_hands.py", "core/robots/test_live.py"
STORE, HISTORY = "console/calibration/test_calibration_store.py", "console/control/test_history_store.py"
STRANGERS, GRAMMAR = "console/http/test_strangers.py", "core/speech/understanding/test_grammar.py"
STATE_MACHINE_TEST = (
    "core/gate/test_gate_state_machine.py::TestAnyOrderOfThings::runTest",
    "console/control/test_control_state_machine.py::TestAnyOrderOfThings::runTest",
)

ROWS = (
    CampaignRow(
        "R1",
        "browser killed while a key is held",
        "zero within 100 ms",
        _in(SOCKET, "a_browser_that_goes_away_while_it_drives_stops_the_robot_at_once"),
        (measure.browser_closed,),
    ),
    CampaignRow(
        "R2",
        "browser frozen, tab hidden, dialog",
        "zero within 300 ms; nothing moves without a new press",
        _in(HANDS, "whatever_takes_the_hands_away_stops_and_the_held_key_stays_dead"),
        (measure.browser_frozen,),
    ),
    CampaignRow(
        "R3",
        "link frozen or late by up to 0.1 s",
        "zero within 300 ms; less than one false stop a minute",
        _in(HANDS, "when_the_link_goes_the_banner_comes_within_a_second_and_the_robot_stands"),
        (measure.link_frozen,),
    ),
    CampaignRow(
        "R4",
        "frames that a link kept arrive when the operator is gone",
        "no motion",
        _in(
            GATE,
            "frames_buffered_through_a_freeze_move_nothing",
            "frames_that_only_trickle_in_are_bounded_by_their_nonce",
            "a_frame_counts_once",
        ),
    ),
    CampaignRow(
        "R5",
        "console killed, frozen, or its loop held up",
        "zero within 150 ms, 300 ms, 300 ms",
        _in("console/test_runtime.py", "a_pilot_that_hangs_is_noticed_and_the_gate_hears_no_heartbeat")
        + _in(SUPERVISOR, "a_frozen_console_means_zero_and_nothing_moves_when_it_wakes"),
        (measure.console_dies,),
    ),
    CampaignRow(
        "R6",
        "gate killed or frozen",
        "the base stops by itself; a new gate is disarmed",
        _in(
            SUPERVISOR,
            "a_dead_gate_stops_the_base_and_a_new_one_is_disarmed",
            "a_frozen_gate_is_replaced_and_the_base_stands_by_itself",
            "a_stop_that_a_frozen_gate_cannot_hear_ends_the_gate",
        )
        + _in("core/robots/test_driver.py", "a_gate_that_is_gone_means_zero"),
    ),
    CampaignRow(
        "R7",
        "driver frozen, busy or gone",
        "zero within 500 ms, disarmed, the fault is shown",
        _in(PROCESS, "a_frozen_driver_does_not_freeze_the_gate", "a_driver_that_is_gone_disarms")
        + _in(
            SUPERVISOR,
            "a_driver_that_is_busy_keeps_neither_gate_nor_base_moving",
            "a_dead_driver_is_replaced_and_the_gate_with_it",
        ),
        (measure.driver_stuck,),
    ),
    CampaignRow(
        "R8",
        "stop command with 50 viewers, one of them stuck",
        "zero: p99 25 ms, at most 100 ms",
        _in(FOLDER, "a_stop_waits_for_no_disk"),
        (measure.stop_command,),
    ),
    CampaignRow("R9", "STOP clicked in Chromium", "zero: p99 60 ms", (), (measure.stop_clicked,)),
    CampaignRow(
        "R10",
        "stop against many commands at once",
        "the last word is stop",
        _in(ORDERS, "the_last_word_of_many_is_stop", "every_stop_acts_whatever_its_number")
        + _in(
            "console/robot/test_setpoint_sender.py",
            "no_order_slips_between_a_stop_and_its_end_however_the_threads_run",
            "after_a_stop_nothing_that_was_entrusted_before_moves",
        ),
    ),
    CampaignRow(
        "R11",
        "halt: kills around its write, restart, takeover, reset with a key held",
        "it stays; the reset moves nothing",
        _in("core/gate/test_latch.py", "kill_9_around_the_write_loses_no_halt_that_was_acknowledged")
        + _in(ORDERS, "a_halt_stays_and_its_reset_moves_nothing")
        + _in(GATE, "halt_is_latched_until_reset_and_reset_does_not_move")
        + _in(SUPERVISOR, "a_halt_outlives_the_console"),
        (measure.halts_kept,),
    ),
    CampaignRow(
        "R12",
        "reconnection, restart, takeover, reset, thaw",
        "nothing ever moves by itself",
        STATE_MACHINE_TEST + _in(LIVE, "after_the_link_came_back_nothing_moves_before_zero_was_asked_for"),
        (measure.any_order, measure.never_by_itself),
    ),
    CampaignRow(
        "R13",
        "setpoints that are no numbers, too large, malformed",
        "refused or cut; the limits hold always",
        _in(
            GATE,
            "a_speed_that_is_no_number_is_zero_and_a_fault",
            "too_much_is_cut_to_the_limits",
            "a_malformed_order_is_refused",
        )
        + _in("core/gate/test_trace.py", "each_violation_is_caught")
        + _in("console/access/test_strict_json.py", "what_is_no_plain_json_is_refused_with_a_sentence"),
    ),
    CampaignRow(
        "R14",
        "two operators",
        "one owner; an older epoch is refused; zero between them",
        _in(
            GATE,
            "another_epoch_is_refused",
            "a_takeover_goes_through_zero_and_needs_a_new_press",
            "an_old_lease_cannot_come_back",
        )
        + _in(
            "console/control/test_lease.py",
            "a_free_lease_is_taken_by_whoever_asks_first",
            "taking_over_raises_the_epoch_and_the_former_driver_is_stale",
        )
        + _in(ORDERS, "only_the_driver_drives_and_taking_over_stops_and_is_told"),
    ),
    CampaignRow(
        "R15",
        "no scan, frozen scan, scans without numbers",
        "zero within 0.5 s",
        _in("core/robots/test_guarded_driving.py", "a_laser_that_fails_stops_it_within_half_a_second")
        + _in(
            GATE,
            "without_a_fresh_scan_it_stands_and_goes_on_when_scans_return",
            "a_long_time_without_scans_is_a_trip",
            "before_the_first_scan_nothing_moves",
        )
        + _in(
            "core/robots/test_nearness.py",
            "a_laser_that_hangs_on_the_move_says_nothing",
            "a_scan_without_a_finite_stamp_tells_nothing",
        ),
    ),
    CampaignRow(
        "R16",
        "an obstacle appears 0.5 m ahead at full speed",
        "no contact",
        _in(
            "core/robots/test_guarded_driving.py",
            "a_box_that_appears_half_a_metre_ahead_is_not_touched",
            "in_free_space_it_is_not_held_up",
        ),
        (measure.things_in_the_way,),
    ),
    CampaignRow(
        "R17",
        "odometry stuck or jumping, place lost",
        "the command ends",
        _in(
            "core/pilot/test_pilot_lost.py",
            "carried_under_way_it_turns_by_leave_of_the_command_which_then_ends",
            "a_carried_robot_stands_refuses_freezes_the_map_and_finds_back_by_turning_on_command",
        )
        + _in("core/robots/test_readings.py", "odometry_that_is_not_of_its_time_is_left_out_and_named"),
    ),
    CampaignRow(
        "R18",
        "camera frozen or black, microphones dead, late pictures and sound",
        "FOLLOW ME and COME HERE stop or refuse",
        _in("core/pilot/test_pilot.py", "no_command_is_driven_by_a_late_picture_sound_or_odometry")
        + _in(
            "core/pilot/test_pilot_sees.py",
            "the_pilot_does_not_look_at_a_camera_that_hangs",
            "unusable_pictures_are_told_once_after_a_second_and_so_is_their_end",
        )
        + _in("core/pilot/test_pilot_hears.py", "samples_that_are_no_numbers_are_no_level"),
    ),
    CampaignRow(
        "R19",
        "transcripts: prose, fragments, numbers",
        "no false motion, no missed stop, no wrong number",
        _in(
            GRAMMAR,
            "prose_never_moves_the_robot_however_it_is_cut",
            "random_text_never_moves_the_robot",
            "whatever_contains_the_word_stop_stops",
            "what_moves_or_is_offered_has_the_number_of_the_words",
            "anything_added_to_a_command_keeps_the_robot_from_moving",
        ),
    ),
    CampaignRow(
        "R20",
        "the word stop before the sentence is over",
        "it stops at once",
        _in("core/speech/test_hearing_words.py", "a_stop_that_is_read_in_a_pause_is_told_at_once")
        + _in("core/speech/sphinx/test_keyword_spotting.py", "stop_is_heard_in_a_hum_and_other_words_are_not_stop"),
    ),
    CampaignRow(
        "R21",
        "words that are old, doubled, in a burst",
        "at most one motion, none by words older than 2 s",
        _in("stories/test_slow_reader.py", "words_that_were_read_late_move_nothing")
        + _in("console/control/test_text_file_reader.py", "a_direction_of_another_time_is_refused_with_its_age"),
        (measure.words_in_stories,),
    ),
    CampaignRow(
        "R22",
        "stranger: every route, method, socket",
        "refused before any data",
        _in(
            GUARD,
            "every_way_in_but_the_door_itself_refuses_a_stranger",
            "a_stranger_does_not_learn_what_exists",
            "a_route_that_forgot_its_role_keeps_the_console_from_starting",
        ),
    ),
    CampaignRow(
        "R23",
        "foreign host, origin, forwarded headers",
        "refused",
        _in(
            GUARD,
            "a_foreign_host_is_refused_everywhere_whatever_it_shows",
            "a_strange_host_header_is_malformed",
            "a_foreign_origin_may_change_nothing_and_open_no_socket",
            "a_cookie_alone_changes_nothing",
        ),
    ),
    CampaignRow(
        "R24",
        "viewer, operator, administrator: every route",
        "as declared",
        _in(
            GUARD,
            "what_a_role_may_is_what_is_declared",
            "a_viewer_stops_and_does_not_drive",
            "there_is_no_role_but_the_four",
        ),
    ),
    CampaignRow(
        "R25",
        "key revoked, signed out",
        "sockets closed within 1 s, cookie dead",
        _in(GUARD, "the_end_of_a_login_closes_its_sockets_and_frees_its_lease")
        + _in(
            "console/access/test_logins_on_disk.py",
            "a_key_that_is_revoked_ends_the_logins_it_opened_and_no_other",
            "what_the_command_line_adds_and_revokes_counts_in_the_running_console",
        ),
    ),
    CampaignRow(
        "R26",
        "secrets in logs, files, addresses",
        "none",
        _in("console/access/test_logins_on_disk.py", "links_and_logins_outlive_a_restart_and_no_secret_is_on_disk")
        + _in(SERVE, "it_tells_two_addresses_keeps_its_secrets_and_ends_promptly_with_sockets_open")
        + _in(ORDERS, "names_and_words_of_people_are_kept_as_they_are_and_never_in_the_log")
        + _in("console/connection/test_reach.py", "passwords_are_not_written_down_and_all_else_is"),
    ),
    CampaignRow(
        "R27",
        "hostile messages by the thousand",
        "no server error, no end of the console",
        _in("console/test_fuzz.py", "a_thousand_hostile_messages_break_nothing"),
    ),
    CampaignRow(
        "R28",
        "malformed and hostile files",
        "refused in a sentence, or what is whole is read",
        _in(
            "core/recording/test_damaged_logs.py",
            "sixty_mutations_of_every_form_are_read_or_refused_in_a_sentence",
            "a_decompression_bomb_stays_small",
            "an_archive_with_objects_inside_is_refused",
        )
        + _in(
            "console/calibration/test_hostile_pictures.py",
            "hostile_pictures_are_refused_in_words_and_in_time",
            "uploads_have_their_own_limits",
        )
        + _in("core/recording/test_sound_file.py", "files_that_lie_or_are_damaged_are_refused_in_a_sentence"),
    ),
    CampaignRow(
        "R29",
        "a calibration that does not end",
        "given up; the console keeps its rate",
        _in(
            "console/calibration/test_hostile_pictures.py",
            "noise_that_takes_for_ever_is_given_up_and_the_session_goes_on",
            "the_console_keeps_its_rate_meanwhile",
        )
        + _in("console/calibration/test_workers.py", "a_job_has_so_much_processor_time_and_no_more"),
    ),
    CampaignRow(
        "R30",
        "paths out of their folder, links, addresses that the console shall fetch",
        "refused",
        _in(
            "console/connection/test_reach.py",
            "every_kind_of_link_reaches_the_networks_that_were_named_by_their_digits_and_nothing_else",
            "files_devices_and_addresses_in_disguise_are_the_administrators",
        )
        + _in("console/maps/test_maps.py", "names_that_could_be_something_else_are_refused")
        + _in("console/test_backup.py", "what_would_lie_elsewhere_is_refused")
        + _in("console/calibration/test_hostile_pictures.py", "names_of_files_are_only_names"),
    ),
    CampaignRow(
        "R31",
        "strangers with half requests, large bodies, bad frames",
        "STOP: p99 25 ms",
        _in(
            STRANGERS,
            "half_requests_take_their_own_places_and_no_more",
            "where_all_places_are_taken_strangers_go_first_then_who_asks_nothing",
        ),
        (measure.under_attack,),
    ),
    CampaignRow(
        "R32",
        "50 viewers and one stuck",
        "round trip of the operator: p99 25 ms; at most 50 MB more",
        _in(SOCKET, "a_stuck_viewer_is_dropped_and_nobody_waits_for_it")
        + _in("console/test_broadcast.py", "one_who_asks_and_never_reads_is_closed_and_memory_stays_bounded"),
        (measure.many_viewers,),
    ),
    CampaignRow(
        "R33",
        "one socket floods",
        "it is closed; a stop in it is heard; nobody else notices",
        _in(
            SOCKET,
            "a_flood_ends_with_1008_and_others_do_not_notice",
            "a_stop_is_heard_even_from_one_who_floods",
            "messages_that_waited_while_the_console_stood_are_no_flood",
        ),
    ),
    CampaignRow(
        "R34",
        "console killed at random; each process killed in turn",
        "nothing acknowledged is lost; up again within 5 s",
        _in(HISTORY, "a_row_that_was_acknowledged_outlives_a_kill")
        + _in("console/maps/test_killed.py", "a_killed_console_has_kept_its_map"),
        (measure.rows_kept, measure.everything_killed),
    ),
    CampaignRow(
        "R35",
        "power cut: tails cut, digits changed",
        "what is whole is used; the file is named; never half a calibration",
        _in(
            STORE,
            "a_crash_while_accepting_or_taking_back_leaves_a_calibration_in_use",
            "a_digit_that_changed_after_it_was_saved_is_told_and_not_used",
        )
        + _in(
            "core/test_files.py",
            "who_is_killed_while_writing_leaves_a_whole_file_no_older_than_what_was_acknowledged",
        )
        + _in(
            "console/maps/test_maps.py",
            "a_map_with_a_changed_digit_is_neither_loaded_nor_packed_and_the_file_is_named",
        )
        + _in(HISTORY, "the_file_is_written_for_the_worst"),
    ),
    CampaignRow(
        "R36",
        "disk full",
        "driving goes on; nothing old is lost; it is said and ends",
        _in(
            FOLDER,
            "a_disk_that_fills_up_is_told_with_507_and_everywhere_until_it_is_over",
            "a_console_does_not_start_on_a_full_disk",
        )
        + _in(HISTORY, "rows_that_met_a_full_disk_are_written_when_it_has_room_again")
        + _in("core/gate/test_trace.py", "a_full_disk_does_not_disturb_the_gate"),
    ),
    CampaignRow(
        "R37",
        "settings that are malformed or unsafe",
        "a reason in one sentence; no limit can be switched off",
        _in(
            "core/gate/test_limits.py",
            "no_limit_can_be_switched_off",
            "the_deadman_stays_between_a_tenth_and_one_second",
        )
        + _in("core/test_settings.py", "a_fault_is_told_in_a_sentence")
        + _in(SERVE, "a_mistyped_setting_is_wrong_usage"),
    ),
    CampaignRow(
        "R38",
        "clock set back, machine asleep",
        "watchdogs stay exact; nothing goes on after sleep",
        _in(GATE, "time_that_runs_backwards_trips")
        + _in(PROCESS, "a_sleep_of_the_machine_ends_what_is_driven_and_what_was_ordered_before")
        + _in(HISTORY, "the_order_is_that_of_the_deeds_whatever_the_clock_does"),
        (measure.slept,),
        size="hours",
    ),
    CampaignRow(
        "R39",
        "a worker is killed",
        "said, started again; driving goes on",
        _in("console/calibration/test_workers.py", "a_worker_that_hangs_or_was_killed_is_given_up_and_started_anew")
        + _in("console/calibration/test_camera_wizard.py", "a_session_survives_the_death_of_its_worker"),
    ),
    CampaignRow(
        "R40",
        "three crashes in a minute",
        "the part stays off, the page says why",
        _in(SUPERVISOR, "three_crashes_in_a_minute_are_the_last")
        + _in("console/test_runtime.py", "a_pilot_that_keeps_failing_stays_off_and_the_console_goes_on"),
    ),
    CampaignRow(
        "R41",
        "second console, port in use, old lock",
        "refused in one sentence, or recovered",
        _in(
            SERVE,
            "a_port_in_use_is_told_in_one_sentence",
            "a_second_console_on_one_data_folder_is_refused_in_one_sentence",
        )
        + _in("console/test_folder_lock.py", "it_is_held_by_one_and_free_again_when_that_one_is_killed"),
    ),
    CampaignRow(
        "R42",
        "SIGTERM and Ctrl-C while driving",
        "zero within 100 ms, then the end",
        _in(
            SERVE,
            "a_goal_that_drives_ends_with_the_console",
            "ctrl_c_and_a_closed_terminal_end_it_without_a_traceback",
        ),
        (measure.told_to_end,),
    ),
    CampaignRow(
        "R43",
        "hours of orders",
        "memory, descriptors, disk stay level",
        _in(
            HISTORY,
            "the_file_stays_bounded_while_the_console_runs",
            "memory_stays_bounded_and_what_runs_is_not_forgotten",
        ),
        (measure.long_life,),
        size="weekly",
        instead="a process that the system ends for want of memory ends as in R34: the robot stands, nothing that "
        "was acknowledged is lost, and all is up again within 5 s; `/metrics` tells the memory of the console",
    ),
    CampaignRow("R44", "page left open", "heap grows at most 5 MB an hour", (), (measure.long_page,), size="hours"),
    CampaignRow(
        "R45",
        "connections that come and go",
        "memory within 5 %, no descriptor left",
        (),
        (measure.comings_and_goings,),
    ),
    CampaignRow(
        "R46",
        "random orders by every way",
        "no rule of the trace broken, no motion without an owner",
        _in("core/gate/test_trace.py", "an_orderly_drive_passes", "each_violation_is_caught"),
        (measure.audited,),
    ),
    CampaignRow("R47", "markup in names, words, notes", "inert on every page", (), (measure.hostile_names,)),
    CampaignRow(
        "R48",
        "no network at all",
        "it starts and drives",
        _in("console/api/test_help.py", "pages_of_help_load_nothing_from_other_hosts"),
        (measure.offline,),
    ),
    CampaignRow(
        "R49",
        "gate beside two busy programs",
        "tick gap: p99 30 ms, at most 60 ms",
        _in("core/gate/test_scheduling.py", "the_gate_comes_before_the_pilot_and_that_before_the_rest"),
        (measure.ticks,),
    ),
    CampaignRow(
        "R50",
        "one line of the safety code taken away",
        "some test goes red",
        (),
        (measure.mutants_killed,),
        size="weekly",
    ),
    CampaignRow(
        "R51",
        "readings late by 0 to 5 s, each wire, each speed",
        "no contact",
        _in(GATE, "scans_that_are_more_than_a_second_late_trip_with_the_lateness"),
        (measure.late_readings,),
    ),
    CampaignRow(
        "R52",
        "stamps that are no numbers, step back, lie ahead",
        "no contact",
        _in("core/robots/test_readings.py", "a_malformed_reading_is_left_out_with_a_fault")
        + _in("core/simulation/test_faulty_robot.py", "scans_of_the_future_are_not_used_for_the_pose_and_said_once"),
        (measure.lying_stamps,),
    ),
    CampaignRow(
        "R53",
        "readings of two robots on one wire",
        "no contact: the robot stands; no sound drive is taken for two robots",
        _in(
            "core/sensors/test_publishers.py",
            "scans_of_two_robots_are_told_whatever_their_turns",
            "odometry_of_two_robots_is_told_and_a_restart_of_one_is_not",
            "one_robot_is_never_taken_for_two_however_it_moves",
        )
        + _in(
            "core/robots/test_readings.py", "of_two_robots_under_one_name_nothing_is_used_and_the_robot_is_not_driven"
        )
        + _in(GATE, "while_the_robot_says_that_it_cannot_be_driven_no_press_moves_it"),
        (measure.two_robots_on_one_wire,),
    ),
    CampaignRow(
        "R54",
        "odometry reset, jumping, without an orientation",
        "no reading that cannot be true is used",
        _in(LIVE, "a_base_that_counts_anew_goes_on_from_where_it_was")
        + _in("core/sensors/test_wheels.py", "fifty_restarts_anywhere_are_no_motion")
        + _in("core/pilot/test_pilot_lost.py", "after_a_restart_of_the_base_the_robot_looks_for_its_place")
        + _in("core/commands/test_obeying.py", "continue_bears_a_pose_that_jumps"),
    ),
    CampaignRow(
        "R55",
        "gate or driver killed: the robot's own failsafe, each wire",
        "its wheels rest after 0.3 s (gate killed) or the base's own 0.5 s, and the time in which they run out",
        _in("core/robots/test_serial_base.py", "without_a_word_the_robot_stops_by_itself")
        + _in("core/robots/test_foxglove.py", "when_the_base_stops_by_itself_the_robots_own_parameters_say"),
        (measure.own_failsafe,),
    ),
    CampaignRow("R56", "two consoles on one robot", "no motion when the second comes", (), (measure.two_consoles,)),
    CampaignRow(
        "R57",
        "console frozen for 6 s with a held key's frames waiting",
        "nothing moves by what waited; the operator is not thrown out",
        _in("stories/test_slow_reader.py", "what_waited_in_the_sockets_of_a_console_that_stood_still_is_not_obeyed"),
        (measure.backlog,),
    ),
    CampaignRow(
        "R58",
        "data folder vanished, read-only, on a disk that does not answer",
        "said; driving goes on",
        _in(
            FOLDER,
            "a_folder_that_is_removed_under_a_console_is_made_again",
            "a_console_does_not_start_where_nothing_can_be_kept",
            "a_disk_that_does_not_answer_is_told",
        )
        + _in("console/test_runtime.py", "a_data_folder_that_cannot_be_written_does_not_stop_the_console")
        + _in(HISTORY, "a_history_that_was_removed_is_begun_again"),
    ),
    CampaignRow(
        "R59",
        "each kind of stored file damaged at the start",
        "it starts, or names the file in a sentence",
        _in(STORE, "a_damaged_calibration_is_not_used_and_not_touched")
        + _in(HISTORY, "a_damaged_file_is_told_and_does_not_stop_the_console")
        + _in("console/access/test_logins_on_disk.py", "a_damaged_file_is_put_aside_and_named")
        + _in("console/people/test_people_school.py", "a_damaged_person_is_left_aside_in_words"),
        (measure.damaged_stores,),
    ),
    CampaignRow(
        "R60",
        "a fleet lost and back",
        "each robot stands or goes on by its own console",
        _in(
            "console/fleet/test_fleet_bus.py",
            "the_loss_of_the_fleet_changes_nothing_at_a_robot_but_is_said_and_it_joins_again",
            "stop_all_names_who_has_not_answered_and_a_halt_takes_who_comes_later",
        )
        + _in("console/fleet/test_table.py", "a_robot_is_live_stale_or_gone_and_stays_in_the_table"),
    ),
)
