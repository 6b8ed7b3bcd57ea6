' Start and stop collecting data; a log row and the last good values at every refresh of the linked area.
'
' The linked area on the sheet Data is fetched by Calc itself, every second, with or without macros. What the macros
' add is told to a listener after each fetch, also after one that failed.
Option Explicit

Global gListener As Object
Global gHeardLink As Object

Const DATA_SHEET = "Data"
Const LAST_SHEET = "Last"
Const LOG_SHEET = "Log"
Const FILTER = "Text - txt - csv (StarCalc)"
Const OPTIONS = "44,34,76,1,,1033,false,true,false,false,false,-1"
Const COMM_FAILURE = 24

Function Setting(sName As String) As Variant
	' A cell of the sheet Settings, by the word before it.
	Dim oCell As Object
	oCell = SettingCell(sName)
	If oCell.Type = com.sun.star.table.CellContentType.TEXT Then
		Setting = oCell.String
	Else
		Setting = oCell.Value
	End If
End Function

Function SettingCell(sName As String) As Object
	SettingCell = ThisComponent.NamedRanges.getByName("PCA_" & UCase(sName)).getReferredCells().getCellByPosition(0, 0)
End Function

Sub WhenLoaded
	If Setting("Running") = 1 Then Listen()
End Sub

Sub StartCollecting
	Dim oLink As Object, nEvery As Long
	nEvery = Setting("Every")
	If nEvery < 1 Then nEvery = 1
	SettingCell("Running").Value = 1
	oLink = Linked()
	If oLink.Url <> Setting("Gateway") & Setting("Source") Then oLink.Url = Setting("Gateway") & Setting("Source")
	Listen()
	oLink.refresh()
	oLink.RefreshDelay = nEvery
End Sub

Sub StopCollecting
	SettingCell("Running").Value = 0
	Linked().RefreshDelay = 0
	StopListening()
End Sub

Function Linked() As Object
	' The linked area; made anew when somebody took it away.
	Dim oLinks As Object, n As Long, oAt As New com.sun.star.table.CellAddress
	oLinks = ThisComponent.AreaLinks
	oAt.Sheet = SheetNumber(DATA_SHEET)
	For n = 0 To oLinks.Count - 1
		If oLinks.getByIndex(n).DestArea.Sheet = oAt.Sheet Then
			Linked = oLinks.getByIndex(n)
			Exit Function
		End If
	Next n
	oLinks.insertAtPosition(oAt, Setting("Gateway") & Setting("Source"), "CSV_all", FILTER, OPTIONS)
	Linked = oLinks.getByIndex(oLinks.Count - 1)
End Function

Function SheetNumber(sName As String) As Long
	SheetNumber = ThisComponent.Sheets.getByName(sName).RangeAddress.Sheet
End Function

Sub Listen
	StopListening()
	gListener = createUnoListener("Area_", "com.sun.star.util.XRefreshListener")
	gHeardLink = Linked()
	gHeardLink.addRefreshListener(gListener)
End Sub

Sub StopListening
	On Error GoTo Gone
	If Not IsNull(gHeardLink) Then gHeardLink.removeRefreshListener(gListener)
Gone:
	gHeardLink = Nothing
	gListener = Nothing
End Sub

Sub Area_disposing(oEvent)
End Sub

Sub Area_refreshed(oEvent)
	' A fault here must not come back every second as a message, so it ends this refresh and no more.
	Dim aRows As Variant
	On Error GoTo Done
	If Setting("Running") <> 1 Then Exit Sub
	aRows = Samples()
	If UBound(aRows) < 1 Then Exit Sub
	If Setting("Log") = "yes" Then AppendLogRow(aRows)
Done:
End Sub

Function Samples() As Variant
	' Rows of the linked area (item ID, value, quality, its name, time), titles first. While the gateway does not
	' answer: the last ones with the quality COMM_FAILURE.
	Dim oSheets As Object, oArea As Object, oLast As Object, aRows As Variant, n As Long, aRow As Variant
	oSheets = ThisComponent.Sheets
	oLast = oSheets.getByName(LAST_SHEET)
	oArea = Linked().DestArea
	aRows = oSheets.getByName(DATA_SHEET).getCellRangeByPosition(0, 0, 4, oArea.EndRow).getDataArray()
	If aRows(0)(0) = "Item ID" Then
		If UsedRows(oLast) > UBound(aRows) + 1 Then oLast.getCellRangeByName("A1:E100000").clearContents(31)
		oLast.getCellRangeByPosition(0, 0, 4, UBound(aRows)).setDataArray(aRows)
		Samples = aRows
		Exit Function
	End If
	aRows = oLast.getCellRangeByPosition(0, 0, 4, UsedRows(oLast) - 1).getDataArray()
	For n = 1 To UBound(aRows)
		aRow = aRows(n)
		aRow(2) = COMM_FAILURE
		aRow(3) = "COMM_FAILURE"
		aRows(n) = aRow
	Next n
	Samples = aRows
End Function

Function UsedRows(oSheet As Object) As Long
	Dim oCursor As Object
	oCursor = oSheet.createCursor()
	oCursor.gotoEndOfUsedArea(False)
	UsedRows = oCursor.RangeAddress.EndRow + 1
End Function

Function UsedColumns(oSheet As Object) As Long
	Dim oCursor As Object
	oCursor = oSheet.createCursor()
	oCursor.gotoEndOfUsedArea(False)
	UsedColumns = oCursor.RangeAddress.EndColumn + 1
End Function

Sub AppendLogRow(aRows As Variant)
	' A row with the time, and value and quality of each item below its own title.
	Dim oLog As Object, aTitles As Variant, aLine() As Variant, nColumns As Long, nRow As Long
	Dim n As Long, nColumn As Long
	oLog = ThisComponent.Sheets.getByName(LOG_SHEET)
	nRow = UsedRows(oLog)
	If nRow > Setting("LogRows") Then Exit Sub
	nColumns = UsedColumns(oLog)
	aTitles = oLog.getCellRangeByPosition(0, 0, nColumns - 1, 0).getDataArray()(0)
	ReDim aLine(nColumns + 2 * UBound(aRows) - 1)
	aLine(0) = CDbl(Now())
	For n = 1 To UBound(aRows)
		nColumn = TitleColumn(aTitles, aRows(n)(0), 2 * n - 1)
		If nColumn = 0 Then
			nColumn = nColumns
			nColumns = nColumns + 2
			oLog.getCellByPosition(nColumn, 0).String = aRows(n)(0)
			oLog.getCellByPosition(nColumn + 1, 0).String = "quality"
			oLog.getCellRangeByPosition(nColumn, 0, nColumn + 1, 0).CellStyle = "Title row"
		End If
		aLine(nColumn) = aRows(n)(1)
		aLine(nColumn + 1) = aRows(n)(2)
	Next n
	ReDim Preserve aLine(nColumns - 1)
	oLog.getCellRangeByPosition(0, nRow, nColumns - 1, nRow).setDataArray(Array(aLine))
	oLog.getCellByPosition(0, nRow).CellStyle = "Time stamp"
End Sub

Function TitleColumn(aTitles As Variant, sItem As String, nLikely As Long) As Long
	' Where an item is logged, 0 for nowhere; it usually is where it was at the last row.
	Dim n As Long
	If nLikely <= UBound(aTitles) Then
		If aTitles(nLikely) = sItem Then
			TitleColumn = nLikely
			Exit Function
		End If
	End If
	For n = 1 To UBound(aTitles) Step 2
		If aTitles(n) = sItem Then
			TitleColumn = n
			Exit Function
		End If
	Next n
	TitleColumn = 0
End Function

Sub ClearLog
	' Rows go, titles stay.
	Dim oLog As Object
	oLog = ThisComponent.Sheets.getByName(LOG_SHEET)
	If MsgBox("Remove all rows of the log?", 4 + 32, "pcaccess") <> 6 Then Exit Sub
	EmptyLog()
End Sub

Sub EmptyLog
	Dim oLog As Object, nRows As Long
	oLog = ThisComponent.Sheets.getByName(LOG_SHEET)
	nRows = UsedRows(oLog)
	If nRows > 1 Then oLog.getCellRangeByPosition(0, 1, UsedColumns(oLog) - 1, nRows - 1).clearContents(1 + 2 + 4 + 16)
End Sub

Sub AddToSource(aItems As Variant)
	' Let the linked area hold these items too.
	Dim oLast As Object, oData As Object, aHad As Variant, aRows As Variant, n As Long, sSource As String, bNew As Boolean
	oData = ThisComponent.Sheets.getByName(DATA_SHEET)
	If oData.getCellByPosition(0, 0).String <> "Item ID" Then oData = ThisComponent.Sheets.getByName(LAST_SHEET)
	aRows = oData.getCellRangeByPosition(0, 0, 0, UsedRows(oData) - 1).getDataArray()
	For n = 1 To UBound(aRows)
		sSource = sSource & "&id=" & Encoded(aRows(n)(0))
	Next n
	For n = 0 To UBound(aItems)
		If InStr(LCase(sSource & "&"), LCase("&id=" & Encoded(aItems(n)) & "&")) = 0 Then
			sSource = sSource & "&id=" & Encoded(aItems(n))
			bNew = True
		End If
	Next n
	If Not bNew Then Exit Sub
	SettingCell("Source").String = "/api/items.csv?" & Mid(sSource, 2)
	Linked().Url = Setting("Gateway") & Setting("Source")
End Sub
