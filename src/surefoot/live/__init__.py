"""The live page and playback in a browser."""
