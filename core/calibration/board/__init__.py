"""The chessboard: found in pictures, judged, printed."""
