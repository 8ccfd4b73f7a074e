"""From a goal to a speed: planner and steering."""
