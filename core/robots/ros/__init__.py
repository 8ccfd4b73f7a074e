"""Robots that speak ROS 1 or ROS 2, whatever link reaches them: message types, the choice of topics, conversions."""
