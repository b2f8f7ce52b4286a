"""Linear model predictive control about the nominal gait."""
