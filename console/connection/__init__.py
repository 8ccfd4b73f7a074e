"""The Connect page's side: what was found on a robot, and the robot files that its operator writes."""
