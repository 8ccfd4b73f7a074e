"""Teaching the robot who somebody is, and keeping what it learnt."""
