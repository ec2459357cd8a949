"""Where something touches the object in the hand, from the wrench that its weight leaves over."""
