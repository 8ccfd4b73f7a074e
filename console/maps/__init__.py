"""Saved maps: kept on the disk, exported, gone on in."""
