"""Where and when to step: nominal gait, DCM plan, step adaptation, swing foot."""
