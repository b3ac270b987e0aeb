// A page against the mock server, for the tests.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { launch, noBrowser, open } from "./browser.mjs";
import { startMock } from "./mock-server.mjs";

let browser;
before(async () => {
  if (!noBrowser) browser = await launch();
});
after(() => browser?.close());

/** A test with a fresh server and page; fails when the page complained in the console. */
export function pageTest(name, body, { mock: mockOptions, context, mayComplain = false } = {}) {
  test(name, { skip: noBrowser }, async () => {
    const mock = await startMock(mockOptions);
    const opened = await open(browser, mock.url, context);
    try {
      await body({ ...opened, mock, sent: (type) => mock.received.filter((message) => message.type === type) });
      if (!mayComplain) assert.deepEqual(opened.complaints, []);
    } finally {
      await opened.close();
      await mock.close();
    }
  });
}
