// Draws a warning under -Wall; that it still compiles shows that Coppice makes nobody's warnings errors.
static int never_called() { return 0; }
