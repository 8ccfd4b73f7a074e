"""The calibration wizards behind the page."""
