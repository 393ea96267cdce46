"""The bench `deployability`: the verdicts on all untwisted foldings of many arrays."""
