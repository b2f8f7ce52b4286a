"""The paper, figure by figure and number by number."""
