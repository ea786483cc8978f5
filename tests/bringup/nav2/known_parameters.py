"""Names of Nav2's parameters, by node and distribution.

Each was found in Nav2's sources: in nav2_bringup/params/nav2_params.yaml, or in a call that declares it, in the branches `jazzy`
(f4108e5), `kilted` (71a1d84) and `lyrical` (aa3dab8) of github.com/ros-navigation/navigation2.
"""

from __future__ import annotations

ALL = {
    "map_server": """
        frame_id topic_name use_sim_time
    """,
    "amcl": """
        alpha1 alpha2 alpha3 alpha4 alpha5 base_frame_id do_beamskip global_frame_id lambda_short
        laser_likelihood_max_dist laser_max_range laser_min_range laser_model_type max_beams max_particles
        min_particles odom_frame_id pf_err pf_z recovery_alpha_fast recovery_alpha_slow resample_interval
        robot_model_type save_pose_rate scan_topic set_initial_pose sigma_hit tf_broadcast transform_tolerance
        update_min_a update_min_d use_sim_time x y yaw z z_hit z_max z_rand z_short
    """,
    "bt_navigator": """
        bt_loop_duration default_cancel_timeout default_server_timeout global_frame navigators odom_topic plugin
        robot_base_frame transform_tolerance use_sim_time wait_for_service_timeout
    """,
    "global_costmap": """
        always_send_full_costmap clearing cost_scaling_factor data_type enabled footprint footprint_padding
        global_frame inf_is_valid inflation_radius map_subscribe_transient_local map_topic marking
        max_obstacle_height min_obstacle_height
        observation_sources obstacle_max_range obstacle_min_range plugin plugins publish_frequency raytrace_max_range
        raytrace_min_range resolution robot_base_frame robot_radius topic track_unknown_space transform_tolerance update_frequency
        use_sim_time
    """,
    "local_costmap": """
        always_send_full_costmap clearing cost_scaling_factor data_type enabled footprint footprint_padding
        global_frame height inf_is_valid inflation_radius marking max_obstacle_height min_obstacle_height observation_sources
        obstacle_max_range obstacle_min_range plugin plugins publish_frequency raytrace_max_range raytrace_min_range
        resolution robot_base_frame robot_radius rolling_window topic transform_tolerance update_frequency use_sim_time width
    """,
    "planner_server": """
        allow_unknown analytic_expansion_ratio angle_quantization_bins change_penalty cost_penalty
        costmap_update_timeout expected_planner_frequency max_iterations max_planning_time minimum_turning_radius
        motion_model_for_search non_straight_penalty planner_plugins plugin reverse_penalty smooth_path tolerance
        use_astar use_sim_time
    """,
    "smoother_server": """
        do_refinement max_its plugin smoother_plugins tolerance use_sim_time
    """,
    "controller_server": """
        acc_lim_theta acc_lim_x acc_lim_y allow_reversing angular_dist_threshold angular_granularity
        approach_velocity_scaling_dist
        controller_frequency controller_plugins costmap_update_timeout critics decel_lim_theta decel_lim_x decel_lim_y
        enable_stamped_cmd_vel failure_tolerance forward_point_distance forward_sampling_distance
        goal_checker_plugins linear_granularity
        lookahead_dist lookahead_time max_allowed_time_to_collision_up_to_carrot max_lookahead_dist max_speed_xy
        max_vel_theta max_vel_x max_vel_y min_approach_linear_velocity min_lookahead_dist min_speed_theta min_speed_xy
        min_theta_velocity_threshold min_vel_x min_vel_y min_x_velocity_threshold min_y_velocity_threshold
        max_angular_accel movement_time_allowance odom_topic plugin primary_controller
        progress_checker_plugins regulated_linear_scaling_min_radius
        regulated_linear_scaling_min_speed required_movement_angle required_movement_radius
        rotate_to_goal_heading rotate_to_heading_angular_vel scale
        short_circuit_trajectory_evaluation sim_time simulate_ahead_time slowing_factor stateful trans_stopped_velocity
        use_collision_detection use_cost_regulated_linear_velocity_scaling use_regulated_linear_velocity_scaling
        use_rotate_to_heading use_sim_time use_velocity_scaled_lookahead_dist vtheta_samples vx_samples vy_samples
        xy_goal_tolerance yaw_goal_tolerance
        ax_max ax_min ay_max ay_min az_max batch_size collision_cost consider_footprint cost_power cost_weight critical_cost
        enabled gamma iteration_count max_angle_to_furthest max_path_occupancy_ratio min_turning_r mode model_dt motion_model
        near_collision_cost near_goal_distance offset_from_furthest prune_distance regenerate_noises
        rotate_to_heading_min_angle temperature threshold_to_consider time_steps trajectory_point_step twirling_cost_power
        twirling_cost_weight use_path_orientations visualize vx_max vx_min vx_std vy_max vy_std wz_max wz_std
    """,
    "waypoint_follower": """
        enabled loop_rate plugin stop_on_failure use_sim_time waypoint_pause_duration waypoint_task_executor_plugin
    """,
    "behavior_server": """
        behavior_plugins cycle_frequency enable_stamped_cmd_vel global_costmap_topic global_footprint_topic
        global_frame local_costmap_topic local_footprint_topic local_frame max_rotational_vel min_rotational_vel
        plugin robot_base_frame rotational_acc_lim simulate_ahead_time transform_tolerance use_sim_time
    """,
    "velocity_smoother": """
        deadband_velocity enable_stamped_cmd_vel feedback max_accel max_decel max_velocity min_velocity odom_duration
        odom_topic scale_velocities smoothing_frequency use_sim_time velocity_timeout
    """,
    "collision_monitor": """
        action_type base_frame_id base_shift_correction cmd_vel_in_topic cmd_vel_out_topic enable_stamped_cmd_vel
        enabled footprint_topic min_points observation_sources odom_frame_id polygons simulation_time_step
        source_timeout state_topic stop_pub_timeout time_before_collision topic transform_tolerance type use_sim_time
        visualize
    """,
    "lifecycle_manager_localization": """
        autostart bond_timeout node_names use_sim_time
    """,
    "lifecycle_manager_navigation": """
        autostart bond_timeout node_names use_sim_time
    """,
}
"""In all three distributions."""

ADDED = {
    "jazzy": {
        "bt_navigator": "error_code_names",
        "controller_server": "desired_linear_vel transform_tolerance",
        "waypoint_follower": "action_server_result_timeout",
    },
    "kilted": {
        "bt_navigator": "error_code_name_prefixes",
        "smoother_server": "enforce_path_inversion",
        "controller_server": "desired_linear_vel transform_tolerance",
        "behavior_server": "acceleration_limit deceleration_limit minimum_speed",
        "lifecycle_manager_localization": "service_timeout",
        "lifecycle_manager_navigation": "service_timeout",
    },
    "lyrical": {
        "bt_navigator": "error_code_name_prefixes",
        "smoother_server": "enforce_path_inversion",
        "controller_server": "enforce_path_inversion max_angular_vel max_linear_vel path_handler_plugins",
        "behavior_server": "acceleration_limit deceleration_limit minimum_speed",
        "lifecycle_manager_localization": "service_timeout",
        "lifecycle_manager_navigation": "service_timeout",
    },
}
"""In one or two of them."""


def known(distribution: str, node: str) -> set[str]:
    """Return the names of a node's parameters."""
    return {*ALL[node].split(), *ADDED[distribution].get(node, "").split()}
