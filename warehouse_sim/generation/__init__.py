"""The stages in order: sample, settle, render, sense, annotate, write; one scene or many."""
