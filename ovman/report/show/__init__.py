"""`ovman show`: a page about one episode, made from the files of a results directory."""
