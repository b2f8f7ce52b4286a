"""The unified controller: ZMP, landing place and landing time from one problem."""
