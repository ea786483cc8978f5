"""Limits without an entry in the table: those that have a test elsewhere, and those that bound no input.

A limit on time is in `TESTED` too: its test gives the package a peer that does not answer, or something that never ends.
"""

from __future__ import annotations

TESTED = {
    "format.bounded_json.MAX_BYTES": "tests/format/test_bounded_json.py::test_the_limits_are_exact",
    "format.bounded_json.MAX_CONTAINERS": "tests/format/test_bounded_json.py::test_the_limits_are_exact",
    "format.bounded_json.MAX_DEPTH": "tests/format/test_bounded_json.py::test_the_limits_are_exact",
    "format.bounded_json.MAX_PARTS": "tests/format/test_bounded_json.py::test_the_limits_are_exact",
    "descriptions.files.references.MAX_FILES_BYTES": (
        "tests/descriptions/files/test_bounds.py::test_all_files_of_a_scene_together_have_a_limit"
    ),
    "ros.lockstep.MAX_AHEAD": "tests/ros/test_lockstep.py::test_a_program_that_sends_too_many_messages_is_an_error",
    "ros.foxglove.publish_gate.MAX_CLIENTS": "tests/ros/test_foxglove.py::test_clients_beyond_the_limit_are_refused",
    "view.page_server.MAX_REQUEST": "tests/view/test_page_server.py::test_a_request_that_is_too_long_is_refused_with_an_answer",
    "api.expectations.bag_file.MAX_MESSAGE_BYTES": (
        "tests/api/expectations/test_bags.py::test_the_size_of_a_compressed_message_is_limited"
    ),
    "api.expectations.bags.MAX_INTERVALS": (
        "tests/api/expectations/test_bags.py::test_a_condition_that_a_bag_cannot_evaluate_is_refused_at_once"
    ),
    "api.gym.scene_env.PATIENCE": "tests/api/gym/test_refusals.py::test_a_mistake_is_told_when_the_environment_is_made",
    "bringup.navigation.true_poses.PATIENCE": (
        "tests/bringup/navigation/test_true_poses.py::test_a_run_that_never_answers_is_refused"
    ),
    "cli.first_run.MOST_TOLD": "tests/cli/test_first_run.py::test_a_line_names_the_worst_joints_up_to_a_number",
    "compiler.budget.MAX_PARTS": "tests/compiler/test_budget.py::test_a_graph_may_hold_as_many_parts_as_the_limit",
    "compiler.planning.regions.MAX_PUSHERS": (
        "tests/compiler/test_scale.py::test_pushers_below_pushers_run_to_a_depth_and_beyond_it_are_refused"
    ),
    "control.lines.PATIENCE": (
        "tests/control/test_channel.py::test_a_line_that_arrives_byte_by_byte_has_the_same_timeout"
    ),
    "control.simulation_interfaces.filters.PATIENCE": (
        "tests/control/test_simulation_interfaces.py::test_a_too_slow_regular_expression_is_refused"
    ),
    "experiments.artefacts.LONGEST": "tests/experiments/test_artefacts.py::test_no_two_runs_share_a_folder",
    "format.process_limits.SMALLEST": "tests/cli/test_limits.py::test_too_little_memory_has_its_own_exit_code",
    "isaac.script.script_reader.SECONDS": "tests/isaac/script/test_hostile.py::test_a_hostile_script_is_contained",
    "isaac.script.script_process.ENDING_SECONDS": "tests/isaac/script/test_hostile.py::test_a_hostile_script_is_contained",
    "isaac.script.script_reader.STARTING_SECONDS": (
        "tests/sandbox/test_confinement.py::test_a_process_that_takes_too_long_is_ended"
    ),
    "descriptions.usd.layers.MAX_MEMORY_BYTES": (
        "tests/sandbox/test_confinement.py::test_a_confined_process_has_no_environment_variables_and_limited_memory"
    ),
    "descriptions.usd.usd_reader.MAX_SECONDS": (
        "tests/sandbox/test_confinement.py::test_a_process_that_takes_too_long_is_ended"
    ),
    "isaac.stage.stage_reader.MAX_SECONDS": (
        "tests/sandbox/test_confinement.py::test_a_process_that_takes_too_long_is_ended"
    ),
    "descriptions.mjcf.mjcf_trial.MAX_MEMORY_BYTES": (
        "tests/sandbox/test_confinement.py::test_a_confined_process_has_no_environment_variables_and_limited_memory"
    ),
    "descriptions.mjcf.mjcf_trial.MAX_SECONDS": (
        "tests/descriptions/mjcf/test_mjcf.py::test_a_model_that_keeps_the_compiler_busy_without_end_is_refused"
    ),
    "descriptions.xacro.xacro.MAX_SECONDS": (
        "tests/descriptions/xacro/test_xacro.py::test_xacro_that_takes_too_long_is_ended"
    ),
    "physics.dynamics.settling.SETTLE_LIMIT": (
        "tests/physics/dynamics/test_settling.py::test_a_body_that_swings_faster_than_the_bound_is_not_at_rest"
    ),
    "descriptions.files.conversion.MAX_SECONDS": (
        "tests/descriptions/files/test_conversion.py::test_a_file_that_takes_too_long_is_ended"
    ),
    "recording.recorder.CHUNK_SECONDS": (
        "tests/recording/test_recorder.py::test_a_large_chunk_is_written_before_its_second_is_over"
    ),
    "ros.foxglove.foxglove_server.BACKLOG": (
        "tests/ros/test_foxglove.py::test_a_client_that_does_not_read_delays_neither_ticks_nor_close"
    ),
    "ros.foxglove.foxglove_server.MAX_PUBLISHED": (
        "tests/ros/test_foxglove.py::test_clients_together_may_advertise_a_limited_number_of_topics"
    ),
    "ros.network_graph.PATIENCE": "tests/ros/test_watch.py::test_a_peer_without_a_node_name_is_reported_after_some_time",
    "ros.service_endpoints.MAX_OPEN": (
        "tests/nodes/test_services.py::test_requests_beyond_the_queue_are_refused_and_reported"
    ),
    "ros.service_endpoints.PATIENCE": "tests/nodes/test_services.py::test_a_missing_server_is_reported_once",
    "ros.transports.dds.cyclone_log.MAX_KINDS": (
        "tests/ros/test_malformed.py::test_forged_packets_are_logged_by_kind_and_then_counted_once_a_minute"
    ),
    "ros.transports.dds.cyclone_log._MAX_SIZE": (
        "tests/ros/test_malformed.py::test_log_lines_that_were_read_are_discarded"
    ),
    "runtime.pacer.Pacer.PATIENCE": ("tests/runtime/test_run.py::test_after_a_long_delay_a_run_does_not_catch_up"),
    "sandbox.confinement.MAX_CPU_SECONDS": (
        "tests/sandbox/test_confinement.py::test_a_process_gets_no_environment_variables_and_ends_at_its_time_limit"
    ),
    "sandbox.confinement.MAX_MEMORY_BYTES": (
        "tests/sandbox/test_confinement.py::test_a_confined_process_has_no_environment_variables_and_limited_memory"
    ),
    "sandbox.confinement.MAX_THREADS": (
        "tests/sandbox/test_confinement.py::test_the_number_of_threads_is_limited_for_root_too"
    ),
    "sandbox.untrusted.MAX_SOURCES": (
        "tests/sandbox/test_untrusted.py::test_source_lines_of_all_files_are_quoted_up_to_a_total_size"
    ),
    "scene.graph_loading.MAX_SCENE_PARTS": (
        "tests/compiler/test_budget.py::test_all_graphs_of_a_scene_share_a_limit_of_nodes_wires_and_variables"
    ),
    "view.page_server.MAX_MESSAGE": ("tests/view/test_page_server.py::test_who_sends_anything_else_is_disconnected"),
    "api.plot_values.MAX_EXPRESSION": "tests/api/test_plot_values.py::test_a_mistake_is_told_and_ends_nothing",
    "api.plot_values.MAX_STEPS": "tests/api/test_plot_values.py::test_a_mistake_is_told_and_ends_nothing",
    "api.plot_values.MAX_SAMPLES": "tests/api/test_plot_values.py::test_there_is_a_most_of_series_and_of_unsent_samples",
    "api.plot_values.MAX_SERIES": "tests/api/test_plot_values.py::test_there_is_a_most_of_series_and_of_unsent_samples",
    "view.kept_token.LONGEST_PAUSE": "tests/view/test_kept_token.py::test_a_file_that_cannot_be_trusted_is_replaced",
    "view.page_server.MAX_VIEWERS": "tests/view/test_page_server.py::test_there_are_no_more_viewers_than_allowed",
}
"""Test by the limit that it covers."""

BOUNDS_NO_INPUT = {
    "a wait of a command for a peer, after which it says so or goes on": (
        "bringup.navigation.initial_pose.PATIENCE",
        "cli.action.CANCEL_PATIENCE",
        "cli.live.SERVER_PATIENCE",
        "cli.nav2.goals.CLOCK_PATIENCE",
        "cli.topic_subscription.PATIENCE",
        "cli.topic.PATIENCE",
        "control.runs.PATIENCE",
        "ros.parameter_client.PATIENCE",
    ),
    "a bound beyond which another part takes over": (
        "api.expectations.sampling_code.MAX_EXPONENT",
        "physics.dynamics.mover_motion.SHORTEST_LAP",
    ),
    "a setting that another program gets": (
        "ros.transports.dds.cyclone.MAX_BLOCKING_MS",
        "ros.ports.MAX_PARTICIPANT_INDEX",
    ),
    "a default that the user can change": ("cli.calibrate.BOUND",),
    "part of a formula, an algorithm or a choice between two ways to the same result": (
        "bringup.calibration.diagnosis.SLOWEST",
        "bringup.calibration.imu_noise.LARGEST_RATE",
        "bringup.calibration.odometry_errors.FARTHEST",
        "bringup.calibration.wheel_geometry.SLOWEST",
        "compiler.codegen.MAX_CALLS",
        "compiler.codegen.MAX_MARKS",
        "messages.message_template.Encoder.PATIENCE",
        "messages.message_template.MAX_PATCHED",
        "nodes.wheeled_robots.stanley.FASTEST_TURN",
        "nodes.wheeled_robots.stanley.SLOWEST",
        "cli.first_run.MOST_JOINTS",
        "cli.first_run.SECONDS",
        "bringup.robots.arm_gains.FASTEST",
        "bringup.robots.resting.SECONDS",
        "bringup.robots.self_view.MOST_BLOCKED",
        "runtime.file_watch.MOST",
    ),
    "what a picture or the page shows": (
        "api.recording_view.LONGEST_SEEK",
        "api.recording_view.MOST_POINTS",
        "api.plot_values.MOST_CHOICES",
        "physics.views.views.FARTHEST",
        "physics.views.views.LARGEST",
        "view.scene.body_dragging.FARTHEST",
        "view.scene.contact_arrows.LONGEST",
        "view.scene.frame_axes.MOST_NAMES",
        "view.scene.lidar_hits.BRIGHTEST",
        "view.scene.robot_trails.MOST_POINTS",
    ),
    "a value above or below which a warning suggests another unit; it is used as it is": (
        "descriptions.joint_units._MOST_DEGREES",
        "descriptions.joint_units._MOST_TURNS",
        "descriptions.files.flat_meshes._FARTHEST",
        "physics.model.mesh_units.LARGEST",
        "physics.model.mesh_units.SMALLEST",
    ),
    "examples in a finding; the others are counted": ("isaac.script.losses.MOST_ASKED",),
}
"""Limits by the reason why nothing that users or strangers give is refused or cut by them."""
