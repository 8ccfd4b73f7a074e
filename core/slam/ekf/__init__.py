"""The extended Kalman filter and its measurement model (eq. 14-33)."""
